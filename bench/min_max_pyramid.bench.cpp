#include "run.hpp"
#include "terrain.hpp"

#include <hfh/terrain/min_max_pyramid.hpp>

#include <array>
#include <cstring>
#include <ctime>
#include <memory>
#include <random>

namespace hfh::bench {
namespace {

/// A raster as large as is asked for, made fast: whole steps of a random walk along each row.
template <Sample S>
struct Raster {
    Index columns, rows;
    std::vector<S> samples;

    Raster(Index w, Index h) : columns{w}, rows{h}, samples(static_cast<std::size_t>(w * h)) {
        std::uint32_t bits = 1;
        int height = 1000;
        for (S& sample : samples) {
            bits = bits * 1664525u + 1013904223u;
            height += static_cast<int>(bits >> 30) - (height > 3000 ? 2 : height < 0 ? 0 : 1);
            sample = static_cast<S>(height);
        }
    }
};

/// One raster at a time is kept: the largest takes half a gigabyte.
template <Sample S>
Raster<S>& raster(Index side) {
    static std::unique_ptr<Raster<S>> kept;
    if (!kept || kept->columns != side) {
        kept.reset();
        kept = std::make_unique<Raster<S>>(side, side);
    }
    return *kept;
}

/// Every byte once, as fast as one core can: sums of 64-bit words that do not wait for one another.
std::uint64_t read_all(const void* memory, std::size_t bytes) {
    constexpr std::size_t lane = 4; // one 256-bit vector
    std::array<std::uint64_t, lane> a{}, b{}, c{}, d{};
    const auto* at = static_cast<const unsigned char*>(memory);
    const auto add = [&](std::array<std::uint64_t, lane>& sum, std::size_t n) {
        for (std::size_t k = 0; k < lane; ++k) {
            std::uint64_t word;
            std::memcpy(&word, at + n + 8 * k, sizeof word);
            sum[k] += word;
        }
    };
    for (std::size_t n = 0; n + 128 <= bytes; n += 128) {
        add(a, n);
        add(b, n + 32);
        add(c, n + 64);
        add(d, n + 96);
    }
    std::uint64_t sum = 0;
    for (std::size_t k = 0; k < lane; ++k) sum += a[k] + b[k] + c[k] + d[k];
    return sum;
}

/// The range of a block of level 0 or of all, sample by sample.
template <class Heights>
auto by_samples(const Heights& heights, Block block, Index side) {
    using S = typename Heights::SampleType;
    SampleRange<S> range;
    bool first = true;
    for (Index j = side * block.j; j <= std::min(side * (block.j + 1), heights.rows() - 1); ++j) {
        for (Index i = side * block.i; i <= std::min(side * (block.i + 1), heights.columns() - 1); ++i) {
            const S sample = heights(i, j);
            if (heights.missing(sample)) return SampleRange<S>{};
            range.lowest = first ? sample : std::min(range.lowest, sample);
            range.highest = first ? sample : std::max(range.highest, sample);
            first = false;
        }
    }
    return range;
}

template <Sample S>
bool same(const SampleRange<S>& a, const SampleRange<S>& b) {
    return a.lowest == b.lowest && a.highest == b.highest;
}

/// The time that this program had a core: other programs on it do not count. A microsecond fine where we looked.
double processor_nanoseconds() {
    return static_cast<double>(std::clock()) * (1e9 / static_cast<double>(CLOCKS_PER_SEC));
}

/// Reads all memory and builds the bounds, by turns.
template <class Heights>
void build(benchmark::State& state, const Heights& heights, const void* memory) {
    using S = typename Heights::SampleType;
    const Index w = heights.columns(), h = heights.rows();
    std::vector<SampleRange<S>> storage(static_cast<std::size_t>(MinMaxPyramid<S>::size(w, h)));
    MinMaxPyramid<S> bounds{storage.data(), std::ssize(storage), w, h};
    const std::size_t bytes = static_cast<std::size_t>(w * h) * sizeof(S);

    // The terrain that fits a cache takes less than the clock can tell.
    const std::size_t passes = 1 + (std::size_t{1} << 26) / bytes;
    double reading = 1e300, building = 1e300;
    for (auto _ : state) {
        const double begin = processor_nanoseconds();
        for (std::size_t n = 0; n < passes; ++n) benchmark::DoNotOptimize(read_all(memory, bytes));
        const double middle = processor_nanoseconds();
        for (std::size_t n = 0; n < passes; ++n) {
            bounds.build(heights);
            benchmark::ClobberMemory();
        }
        const double end = processor_nanoseconds();
        reading = std::min(reading, (middle - begin) / static_cast<double>(passes));
        building = std::min(building, (end - middle) / static_cast<double>(passes));
        state.SetIterationTime((end - middle) * 1e-9 / static_cast<double>(passes));
    }

    std::mt19937 bits{50};
    constexpr Index side = Index{1} << MinMaxPyramid<S>::block_bits;
    for (int n = 0; n < 1000; ++n) {
        const Block block{static_cast<Index>(bits() % static_cast<unsigned>((w - 2) / side + 1)),
                          static_cast<Index>(bits() % static_cast<unsigned>((h - 2) / side + 1))};
        if (!same(bounds.range(0, block), by_samples(heights, block, side))) {
            return fail(state, "not the bounds of a block");
        }
    }
    if (!same(bounds.range(bounds.levels() - 1, {0, 0}), by_samples(heights, {0, 0}, std::max(w, h)))) {
        return fail(state, "not the bounds of all");
    }
    state.counters["bytes_a_sample"] =
        static_cast<double>(storage.size() * sizeof storage[0]) / static_cast<double>(w * h);
    state.counters["GB/s"] = static_cast<double>(bytes) / building;
    state.counters["read_GB/s"] = static_cast<double>(bytes) / reading;
    state.counters["of_read_speed"] = reading / building;
}

/// A brush of 10 × 10 samples anywhere: edit, then update. Only the update is of interest, but the edit is in the time,
/// as without it there is no update.
void update(benchmark::State& state, std::vector<std::int16_t>& samples, Index w, Index h) {
    constexpr Index brush = 10;
    const HeightView heights{samples.data(), w, h};
    std::vector<SampleRange<std::int16_t>> storage(
        static_cast<std::size_t>(MinMaxPyramid<std::int16_t>::size(w, h)));
    MinMaxPyramid<std::int16_t> bounds{storage.data(), std::ssize(storage), w, h};
    bounds.build(heights);
    std::mt19937 bits{51};
    std::vector<Vertex> places;
    for (int n = 0; n < 1024; ++n) {
        places.push_back({static_cast<Index>(bits() % static_cast<unsigned>(w - brush)),
                          static_cast<Index>(bits() % static_cast<unsigned>(h - brush))});
    }
    std::int16_t height = 0;
    const auto edit = [&](Vertex at) {
        height = static_cast<std::int16_t>((height + 7) % 4000);
        for (Index j = at.j; j < at.j + brush; ++j) {
            for (Index i = at.i; i < at.i + brush; ++i) samples[static_cast<std::size_t>(i + j * w)] = height;
        }
        bounds.update(heights, {at, {at.i + brush, at.j + brush}});
    };
    while (state.KeepRunningBatch(static_cast<benchmark::IterationCount>(places.size()))) {
        for (const Vertex at : places) edit(at);
    }
    for (const Vertex at : places) {
        edit(at);
        constexpr Index side = Index{1} << bounds.block_bits;
        const Block block{at.i / side, at.j / side};
        if (!same(bounds.range(0, block), by_samples(heights, block, side))) {
            return fail(state, "not the bounds of an edited block");
        }
    }
    auto fresh = storage;
    MinMaxPyramid<std::int16_t>{fresh.data(), std::ssize(fresh), w, h}.build(heights);
    if (!std::equal(fresh.begin(), fresh.end(), storage.begin(), same<std::int16_t>)) {
        return fail(state, "an update is not a new build");
    }
}

/// Alternating with the reading of memory, so with a clock of its own.
template <class Body>
void add_build(const std::string& name, Body&& body) {
    benchmark::RegisterBenchmark(name.c_str(), std::forward<Body>(body))->UseManualTime()->MinTime(0.3);
}

} // namespace

void register_benchmarks() {
    add_build("min_max_pyramid/build/hills_1.56M/int16", [](benchmark::State& state) {
        const Terrain& ground = terrain(large_hills);
        state.SetLabel(ground.label());
        build(state, ground.grid<double>().heights(), ground.samples.data());
    });
    add_build("min_max_pyramid/build/16385/int16", [](benchmark::State& state) {
        const auto& r = raster<std::int16_t>(16385);
        build(state, HeightView{r.samples.data(), r.columns, r.rows}, r.samples.data());
    });
    add_build("min_max_pyramid/build/16385/int16_with_no_data", [](benchmark::State& state) {
        const auto& r = raster<std::int16_t>(16385);
        build(state, HeightView{r.samples.data(), r.columns, r.rows, MissingValue<std::int16_t>{-1}},
              r.samples.data());
    });
    // The walk stays near 3000: holes everywhere, and all pieces are read twice.
    add_build("min_max_pyramid/build/16385/int16_full_of_holes", [](benchmark::State& state) {
        const auto& r = raster<std::int16_t>(16385);
        build(state, HeightView{r.samples.data(), r.columns, r.rows, MissingValue<std::int16_t>{3000}},
              r.samples.data());
    });
    add_build("min_max_pyramid/build/8193/float", [](benchmark::State& state) {
        const auto& r = raster<float>(8193);
        build(state, HeightView{r.samples.data(), r.columns, r.rows}, r.samples.data());
    });
    add_build("min_max_pyramid/build/8193/double", [](benchmark::State& state) {
        const auto& r = raster<double>(8193);
        build(state, HeightView{r.samples.data(), r.columns, r.rows}, r.samples.data());
    });
    add("min_max_pyramid/update/brush_10/hills_1.56M/int16", [](benchmark::State& state) {
        Terrain ground = terrain(large_hills);
        state.SetLabel(ground.label());
        update(state, ground.samples, ground.kind.columns, ground.kind.rows);
    });
    add("min_max_pyramid/update/brush_10/16385/int16", [](benchmark::State& state) {
        auto& r = raster<std::int16_t>(16385);
        update(state, r.samples, r.columns, r.rows);
    });
}

} // namespace hfh::bench
