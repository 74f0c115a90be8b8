#ifndef TOUCH_TERRAIN_TIP_OPTIONS_HPP
#define TOUCH_TERRAIN_TIP_OPTIONS_HPP

#include <string>

namespace CLI {
class App;
}

namespace demo {

/// The ball at the end of the stylus, by its radius; without one a point. At most one of the two is not 0.
struct Tip {
    double on_terrain = 0; ///< m of terrain
    double at_hand =
        0; ///< m at the hand: on the terrain as many times as large as the scale of the workspace

    /// m of terrain, at a scale of so many metres of terrain per metre of hand.
    [[nodiscard]] double radius(double scale) const noexcept { return on_terrain + scale * at_hand; }
};

/// The part of a command line that says what touches: --tip and --tip-hand, and --release. The command line refers to it.
class TipCommandLine {
public:
    explicit TipCommandLine(CLI::App& app);
    TipCommandLine(const TipCommandLine&) = delete;
    TipCommandLine& operator=(const TipCommandLine&) = delete;

    /// Once the command line has been parsed. Throws BadInput.
    [[nodiscard]] Tip tip() const;
    /// How fast a proxy glides that a ridge lets go, metres of the hand an update; 0: it does not glide. As `tip`.
    [[nodiscard]] double release_speed() const;

private:
    const CLI::App* app_;
    std::string on_terrain_, at_hand_, release_;
};

} // namespace demo

#endif // TOUCH_TERRAIN_TIP_OPTIONS_HPP
