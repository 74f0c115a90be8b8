#include "bounded.hpp"
#include "strokes.hpp"

#include <cstring>

// What the optional bounds cost to have: memory, and the pass that makes them against a pass that only reads.

namespace hfh::bench {
namespace {

/// The sum of all bytes in words of eight, in four chains so that no addition waits: as fast as one core reads.
std::uint64_t read_all(const std::int16_t* samples, std::size_t count) noexcept {
    constexpr std::size_t lanes = 32;
    std::uint64_t sum[lanes] = {};
    const auto* bytes = reinterpret_cast<const unsigned char*>(samples);
    const std::size_t size = 2 * count / (8 * lanes) * (8 * lanes);
    for (std::size_t at = 0; at < size; at += 8 * lanes) {
        std::uint64_t words[lanes];
        std::memcpy(words, bytes + at, sizeof words);
        for (std::size_t k = 0; k < lanes; ++k) sum[k] += words[k];
    }
    std::uint64_t total = 0;
    for (const auto s : sum) total += s;
    return total;
}

} // namespace

Findings bounds(const Settings& settings) {
    Findings found;
    // Larger than any cache.
    const Index side = settings.vast ? 16385 : 8193;
    const auto ground = hills_in_memory("hills", side, side);
    const auto samples = static_cast<std::size_t>(side * side);
    Bounded bounded{ground.grid<double>()};
    found.numbers.push_back(
        {"bounds_memory", "", static_cast<double>(bounded.bytes()) / static_cast<double>(samples)});
    const auto paces =
        race({{1, static_cast<double>(samples),
               [&](std::size_t) { benchmark::DoNotOptimize(read_all(ground.samples.get(), samples)); }},
              {1, static_cast<double>(samples),
               [&](std::size_t) {
                   if (!bounded.build()) throw Fault{"no bounds could be built"};
               }}},
             7);
    found.numbers.push_back({"bounds_build",
                             "",
                             paces[0].fastest / paces[1].fastest,
                             {},
                             "reading " + text(2 / paces[0].fastest) + " GB/s, building " +
                                 text(2 / paces[1].fastest) + " GB/s, " +
                                 text(static_cast<double>(samples) / 1e6) + " M samples"});
    // The ranges hold what they bound.
    const auto& field = bounded.field();
    const Index wide = Index{1} << field.block_bits;
    for (Index J = 0; J < (side - 2) / wide; J += 37) {
        for (Index I = 0; I < (side - 2) / wide; I += 41) {
            double low = 1e300, high = -1e300;
            for (Index j = wide * J; j <= wide * J + wide; ++j) {
                for (Index i = wide * I; i <= wide * I + wide; ++i) {
                    low = std::min(low, ground.sample(i, j));
                    high = std::max(high, ground.sample(i, j));
                }
            }
            const auto range = field.block_range(0, {I, J}, {I, J});
            if (range.lowest != low || range.highest != high) throw Fault{"a block's bounds are wrong"};
        }
    }
    return found;
}

} // namespace hfh::bench
