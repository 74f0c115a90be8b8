// An editor beside the haptic thread. The heights belong to the haptic thread alone: the editor sends it edits through a
// queue, and the haptic thread makes them between two updates, a bounded number each time. So no update sees a height
// change while it looks, and no thread waits for the other.
//
// Here an editor draws waves into the ground while a hand is dragged over it, without a pause between updates, which is
// harder than a thousand a second. Ends with 0 if all edits arrived, the hand was never lost, and the force made no step that
// a hand would notice.

#include "single_queue.hpp"

#include <hfh/hfh.hpp>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <thread>
#include <vector>

namespace {

constexpr int columns = 128, rows = 16;
constexpr double spacing = 0.002, stiffness = 500; // m, N/m
constexpr int passes = 100, edits_an_update = 32;
constexpr int edits_in_all = passes * columns * rows;

/// Sample (i, j) is to have this height.
struct Edit {
    int i, j;
    float height;
};
using Edits = recipes::SingleQueue<Edit, 1024>;

/// Waves of 2 mm that rise in so many passes over the ground. An editor that has to know the heights keeps a copy: those of
/// the haptic thread are not its to read.
void edit(Edits& edits) {
    for (int n = 0; n < edits_in_all; ++n) {
        const int pass = n / (columns * rows) + 1, i = n % columns, j = n / columns % rows;
        const double waves = 0.001 * std::sin(0.1 * i) * std::cos(0.15 * j);
        const Edit e{i, j, static_cast<float>(waves * pass / passes)};
        while (!edits.push(e)) std::this_thread::yield(); // the editor may wait
    }
}

} // namespace

int main() {
    std::vector<float> heights(columns * rows, 0.0f);
    const hfh::BilinearGrid grid{hfh::HeightView{heights.data(), columns, rows},
                                 {.spacing = {spacing, spacing}}};
    hfh::ProxyTracker tracker{grid};
    const hfh::ForceEvaluator<double> force{.stiffness = stiffness};

    Edits edits;
    std::thread editor{[&] { edit(edits); }};
    int made = 0, updates = 0, lost = 0;
    double largest_step = 0;
    hfh::vec3<double> last_force{0.0};
    while (made < edits_in_all || updates < 1000) {
        // Between two updates: as many edits as there is time for.
        int now = 0;
        for (Edit e; now < edits_an_update && edits.pop(e); ++now)
            heights[static_cast<std::size_t>(e.i + e.j * columns)] = e.height;
        made += now;

        const double way = 0.1 * (1 - std::cos(0.0003 * updates));
        const double down = std::min(0.01, 0.00001 * updates);
        const auto contact = tracker.update({0.02 + way, 0.016, 0.005 - down});
        const auto felt = force(contact).newtons;
        lost += down >= 0.01 && !contact.touching();
        largest_step = std::max(largest_step, glm::length(felt - last_force));
        last_force = felt;
        ++updates;
    }
    editor.join();
    std::printf("%d edits in %d updates, contact lost %d times, force %.2f N, largest step %.4f N\n", made,
                updates, lost, glm::length(last_force), largest_step);
    return made == edits_in_all && lost == 0 && largest_step < 0.03 ? 0 : 1;
}
