// A scene without optional pieces, compiled twice: as it is, and after every optional header was included. The object
// files have to be the same to the byte: who does not use a piece does not pay for it.

#include <hfh/hfh.hpp>

#ifdef HFH_TEST_WITH_PIECES
#include <hfh/damping.hpp>
#include <hfh/force_shading.hpp>
#include <hfh/friction.hpp>
#include <hfh/level_beyond.hpp>
#include <hfh/raised_field.hpp>
#endif

hfh::vec3<double> plain_update(hfh::ProxyTracker<hfh::BilinearGrid<double, hfh::HeightView<float>>>& tracker,
                               const hfh::ForceEvaluator<double>& force,
                               const hfh::vec3<double>& stylus) noexcept;
hfh::vec3<double> plain_update(hfh::ProxyTracker<hfh::BilinearGrid<double, hfh::HeightView<float>>>& tracker,
                               const hfh::ForceEvaluator<double>& force,
                               const hfh::vec3<double>& stylus) noexcept {
    return force(tracker.update(stylus)).newtons;
}
