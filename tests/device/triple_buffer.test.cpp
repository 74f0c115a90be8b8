#include "catch.hpp"
#include "support/allocations.hpp"

#include <hfh/device/triple_buffer.hpp>

using namespace hfh;

TEST_CASE("TripleBuffer: the last value wins, and is told to be new once", "[triple_buffer]") {
    TripleBuffer<int> latest;
    int value = -1;
    CHECK_FALSE(latest.take(value));
    CHECK(value == 0); // T{} before any
    latest.put(1);
    latest.put(2);
    latest.put(3);
    CHECK(latest.take(value));
    CHECK(value == 3);
    value = -1;
    CHECK_FALSE(latest.take(value));
    CHECK(value == 3); // still the last
    latest.put(4);
    CHECK(latest.take(value));
    CHECK(value == 4);
}

TEST_CASE("TripleBuffer: every order of puts and takes hands over the last put", "[triple_buffer]") {
    // All sequences of 16 steps, bit by bit.
    for (unsigned steps = 0; steps < 1u << 16; ++steps) {
        TripleBuffer<unsigned> latest;
        unsigned last = 0, taken = 0, value = 0;
        for (unsigned n = 0; n < 16; ++n) {
            if ((steps >> n & 1u) != 0) {
                latest.put(++last);
                continue;
            }
            const bool is_new = latest.take(value);
            if (value != last || is_new != (last != taken)) FAIL("steps " << steps << " at " << n);
            taken = last;
        }
    }
    SUCCEED();
}

TEST_CASE("TripleBuffer: neither throws nor allocates", "[triple_buffer]") {
    struct Big {
        double numbers[100];
    };
    TripleBuffer<Big> latest;
    Big big{};
    static_assert(noexcept(latest.put(big))&& noexcept(latest.take(big)));
    const auto before = test::allocations();
    latest.put(big);
    CHECK(latest.take(big));
    CHECK(test::allocations() == before);
}
