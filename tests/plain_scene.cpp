// A scene without optional pieces, compiled twice: as it is, and after every header of the library was included. The
// object files have to be the same to the byte, so the same instructions run on the same state: who does not use a
// piece does not pay for it.

#include <hfh/hfh.hpp>

#ifdef HFH_TEST_WITH_PIECES
#include "all_headers.hpp"
#endif

hfh::vec3<double> plain_update(hfh::ProxyTracker<hfh::BilinearGrid<double, hfh::HeightView<float>>>& tracker,
                               const hfh::ForceEvaluator<double>& force,
                               const hfh::vec3<double>& stylus) noexcept;
hfh::vec3<double> plain_update(hfh::ProxyTracker<hfh::BilinearGrid<double, hfh::HeightView<float>>>& tracker,
                               const hfh::ForceEvaluator<double>& force,
                               const hfh::vec3<double>& stylus) noexcept {
    return force(tracker.update(stylus)).newtons;
}
