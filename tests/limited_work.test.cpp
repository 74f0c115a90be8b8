#include "support/limited_work.hpp"
#include "catch.hpp"
#include "support/watchdog.hpp"

#include <hfh/hfh.hpp>

#include <array>
#include <cstdint>
#include <cstdio>

// `max_patches` and `max_slide` from 1 up, on ground of every kind: what may never happen under them.

using namespace hfh;
using namespace hfh::test;

TEMPLATE_TEST_CASE("ProxyTracker: whatever work is allowed, no contact is dropped and the proxy gets there",
                   "[proxy_tracker][limited][law]", float, double) {
    using T = TestType;
    const Watchdog watchdog{"an update with limited work", 120};
    Random random{141};
    long updates = 0, contacts = 0, rests = 0;
    int faults = 0;
    for (int n = 0; n < 3000 && faults < 5; ++n) {
        const auto kind = static_cast<HardGround>(n % hard_grounds);
        const auto ground = hard_ground<T>(kind, random);
        const TrackerOptions options{.surface = random.one_in(5) ? SurfaceKind::sheet : SurfaceKind::solid,
                                     .max_patches = any_limit(random),
                                     .max_slide = any_limit(random)};
        LimitedWork<T> work{ground, options};
        stroke_about(work, ground, random);
        updates += work.updates, contacts += work.contacts, rests += work.rests;
        if (!work.fault().empty()) {
            ++faults; // as it is, for Catch would break its lines
            std::fprintf(stderr, "ground %d, %s\n", n, work.fault().c_str());
        }
    }
    CHECK(faults == 0);
    if (faults == 0) { // and there was something to judge
        CHECK(contacts * 3 > updates);
        CHECK(rests > 5000);
    }
}
