#include "bounded.hpp"
#include "casts.hpp"
#include "text.hpp"

#include <functional>

// First crossings of segments anywhere on the ground, in any direction, half of which end under it: so many that on the
// larger grounds the last cache does not hold what they touch. Each peer is built, timed against the library and freed
// before the next one.

namespace hfh::bench {
namespace {

constexpr double short_lengths[] = {0.5, 3, 30}, long_lengths[] = {300, 3000};
constexpr std::size_t queries_a_length = 32'768;
constexpr int rounds = 3; // bench.py takes the median of five runs

template <class Field, class G>
std::vector<CastSet<double>> make_sets(const Field& field, const G& ground, const double* lengths,
                                       std::size_t count) {
    std::vector<CastSet<double>> sets;
    for (std::size_t l = 0; l < count; ++l) {
        const double length = lengths[l];
        if (1.2 * length > static_cast<double>(std::max(ground.kind.columns, ground.kind.rows))) continue;
        // The longest ones are fewer, to take no longer.
        const std::size_t queries = length > 300 ? queries_a_length / 8 : queries_a_length;
        CastSet<double> set = cast_set<double>(field, ground, length, queries);
        check_casts(ground, set);
        sets.push_back(std::move(set));
    }
    return sets;
}

/// One length: the fastest of a library's peers.
struct Best {
    double ratio = 0, peer_ns = 0, ours_ns = 0;
    std::string name, errors;
    std::string excluded; ///< peers that were left out, and why
};

/// Of the hits in `right`.
double share_missed(const std::vector<double>& right, const std::vector<double>& t) {
    double hits = 0, missed = 0;
    for (std::size_t k = 0; k < t.size(); ++k) {
        hits += right[k] <= 1 ? 1 : 0;
        missed += right[k] <= 1 && t[k] > 1 ? 1 : 0;
    }
    return hits > 0 ? missed / hits : 0;
}

template <class Field, class G>
void race_peer(CastPeer& peer, const Field& field, const G& ground, std::vector<CastSet<double>>& sets,
               std::vector<Best>& best) {
    for (std::size_t l = 0; l < sets.size(); ++l) {
        auto& set = sets[l];
        std::vector<double> t(set.queries.size());
        const auto theirs = [&](std::size_t slice) {
            peer.cast(&set.queries[slice * casts_a_slice], casts_a_slice, &t[slice * casts_a_slice]);
        };
        const auto paces =
            race({casts(field, set),
                  {set.queries.size() / casts_a_slice, static_cast<double>(casts_a_slice), theirs}},
                 rounds);
        // A peer that misses more than one hit in a hundred is no rival, however fast.
        const double wrong = share_missed(set.t, t);
        if (wrong > 0.01) {
            best[l].excluded += "; " + peer.name() + " missed " + text(100 * wrong, 2) + " % of the hits";
            continue;
        }
        if (best[l].peer_ns > 0 && best[l].peer_ns <= paces[1].fastest) continue;

        double sum = 0, largest = 0, count = 0, missed = 0, invented = 0;
        for (std::size_t k = 0; k < t.size(); ++k) {
            missed += set.t[k] <= 1 && t[k] > 1 ? 1 : 0;
            invented += set.t[k] > 1 && t[k] <= 1 ? 1 : 0;
            if (t[k] > 1) continue;
            const glm::dvec3 at = set.queries[k].a + t[k] * (set.queries[k].b - set.queries[k].a);
            const double off = std::abs(at.z - ground.surface(at.x, at.y));
            sum += off, count += 1, largest = std::max(largest, off);
        }
        best[l].ratio = paces[1].fastest / paces[0].fastest;
        best[l].peer_ns = paces[1].fastest;
        best[l].ours_ns = paces[0].fastest;
        best[l].name = peer.name();
        best[l].errors = text(count > 0 ? sum / count : 0, 2) + " / " + text(largest, 2) + " m";
        if (missed + invented > 0) {
            best[l].errors += " (" + text(missed) + " missed, " + text(invented) + " invented of " +
                              text(static_cast<double>(t.size())) + ")";
        }
    }
}

using Maker = std::function<std::unique_ptr<CastPeer>(const PeerHeights&)>;
/// What a library has to offer, each way of it a peer.
struct Library {
    const char* name;
    const char* goal; ///< of casts up to 30 cells
    std::vector<Maker> makers;
};
std::vector<Library> all_libraries() {
    Library bullet{"Bullet", "crossing_bullet", {}}, embree{"Embree 3", "crossing_embree", {}};
#ifdef HFH_HAS_BULLET
    for (const bool accelerator : {false, true}) {
        bullet.makers.push_back([=](const PeerHeights& h) { return bullet_height_field(h, accelerator); });
    }
#endif
#ifdef HFH_HAS_EMBREE
    for (const auto mesh : {EmbreeMesh::triangles, EmbreeMesh::quads, EmbreeMesh::grid}) {
        embree.makers.push_back([=](const PeerHeights& h) { return embree_casts(h, mesh); });
    }
#endif
    return {bullet, embree};
}

void enter(const char* goal, const TerrainKind& kind, const std::vector<CastSet<double>>& sets,
           const std::vector<Best>& best, Findings& found) {
    const std::string size = text(static_cast<double>((kind.columns - 1) * (kind.rows - 1)) / 1e6) + " M";
    for (std::size_t l = 0; l < sets.size(); ++l) {
        const Best& peer = best[l];
        if (peer.peer_ns == 0) continue; // all missed too many hits
        found.numbers.push_back(
            {goal,
             text(sets[l].length) + " cells, " + size,
             peer.ratio,
             {peer.peer_ns, peer.ours_ns},
             peer.name + ", heights hit off by, mean / largest: " + peer.errors + peer.excluded});
    }
}

constexpr const char* long_casts = "long_casts";

template <class G>
void on(const G& ground, Findings& found) {
    const auto grid = ground.template grid<double>();
    auto sets = make_sets(grid, ground, short_lengths, std::size(short_lengths));
    Bounded bounded{grid};
    if (!bounded.build()) throw Fault{"no bounds could be built"};
    auto far_sets = make_sets(bounded.field(), ground, long_lengths, std::size(long_lengths));
    for (const auto& library : all_libraries()) {
        std::vector<Best> best(sets.size()), far_best(far_sets.size());
        const bool reaches_far = std::string{library.name}.starts_with("Embree");
        for (const auto& make : library.makers) {
            const auto peer = make(for_peers(ground));
            race_peer(*peer, grid, ground, sets, best);
            if (reaches_far) race_peer(*peer, bounded.field(), ground, far_sets, far_best);
        }
        enter(library.goal, ground.kind, sets, best, found);
        if (reaches_far) enter(long_casts, ground.kind, far_sets, far_best, found);
    }
}

} // namespace

Findings crossing(const Settings&) {
    Findings found;
    bool any_peer = false;
    for (const auto& library : all_libraries()) {
        any_peer = any_peer || !library.makers.empty();
        if (!library.makers.empty()) continue;
        const std::string why = std::string{library.name} + " is not installed";
        found.skipped.push_back({library.goal, why});
        if (std::string{library.name}.starts_with("Embree")) found.skipped.push_back({long_casts, why});
    }
    if (!any_peer) return found;
    on(terrain(small_hills), found);
    on(terrain(large_hills), found);
    on(hills_in_memory("hills", 4097, 4097), found);
    return found;
}

} // namespace hfh::bench
