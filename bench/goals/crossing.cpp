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
constexpr int rounds = 5;

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
struct Peer {
    std::string name;
    std::vector<Maker> makers;
};
std::vector<Peer> all_peers() {
    std::vector<Peer> peers{{"Bullet's height field", {}}, {"Embree", {}}};
#ifdef HFH_HAS_BULLET
    for (const bool accelerator : {false, true}) {
        peers[0].makers.push_back([=](const PeerHeights& h) { return bullet_height_field(h, accelerator); });
    }
#endif
#ifdef HFH_HAS_EMBREE
    for (const auto mesh : {EmbreeMesh::triangles, EmbreeMesh::quads, EmbreeMesh::grid}) {
        peers[1].makers.push_back([=](const PeerHeights& h) { return embree_casts(h, mesh); });
    }
#endif
    return peers;
}

Row row_of(const std::string& name, const std::vector<CastSet<double>>& sets, const std::vector<Best>& best) {
    Row row{name, "×", {}};
    std::string errors, excluded;
    for (std::size_t l = 0; l < sets.size(); ++l) {
        row.figures.push_back({text(sets[l].length) + " cells", Figure::Goal::more_than, 1});
        if (best[l].peer_ns == 0) continue;
        row.figures.back().measured = best[l].ratio;
        row.beside += (l > 0 ? ", " : "") + text(best[l].peer_ns) + " against " + text(best[l].ours_ns) +
                      " ns (" + best[l].name + ")";
        errors += (l > 0 ? ", " : "") + best[l].errors;
        excluded += best[l].excluded;
    }
    if (!errors.empty()) row.beside += "; heights hit off by, mean / largest: " + errors + excluded;
    return row;
}

std::string million_cells(const TerrainKind& kind) {
    return text(static_cast<double>((kind.columns - 1) * (kind.rows - 1)) / 1e6) + " M cells";
}

template <class G>
void on(const G& ground, Findings& found, std::vector<Row>& bounded_rows) {
    const auto grid = ground.template grid<double>();
    auto sets = make_sets(grid, ground, short_lengths, std::size(short_lengths));
#ifdef HFH_HAS_BOUNDS
    Bounded bounded{grid};
    if (!bounded.build()) throw Fault{"no bounds could be built"};
    auto far_sets = make_sets(bounded.field(), ground, long_lengths, std::size(long_lengths));
#else
    auto far_sets = make_sets(grid, ground, long_lengths, std::size(long_lengths));
#endif
    for (const auto& library : all_peers()) {
        std::vector<Best> best(sets.size()), far_best(far_sets.size());
        for (const auto& make : library.makers) {
            const auto peer = make(for_peers(ground));
            race_peer(*peer, grid, ground, sets, best);
#ifdef HFH_HAS_BOUNDS
            if (library.name == "Embree") {
                race_peer(*peer, bounded.field(), ground, far_sets, far_best);
            }
#endif
        }
        const std::string where = ", " + million_cells(ground.kind);
        found.rows.push_back(
            row_of("first crossing, 0.5 / 3 / 30 cells, time of " + library.name + " over ours" + where, sets,
                   best));
        if (library.name == "Embree") {
            bounded_rows.push_back(row_of("first crossing, " +
                                              std::string{far_sets.size() > 1 ? "300 / 3000" : "300"} +
                                              " cells, with bounds, time of Embree over ours" + where,
                                          far_sets, far_best));
        }
    }
}

} // namespace

Findings crossing(const Settings&) {
    Findings found;
    std::vector<Row> bounded_rows;
    on(terrain(0), found, bounded_rows);
    on(terrain(1), found, bounded_rows);
    on(made_up_ground("hills", 4097, 4097), found, bounded_rows);
    for (auto& row : bounded_rows) found.rows.push_back(std::move(row));
    return found;
}

} // namespace hfh::bench
