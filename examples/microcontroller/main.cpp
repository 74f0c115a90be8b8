#include "board.hpp"
#include "recorded_strokes.hpp"

#include <hfh/device/force_guard.hpp>
#include <hfh/hfh.hpp>

#include <bit>
#include <concepts>
#include <cstdint>

// Strokes over ground in flash, as firmware would feel them: stylus → contact → force → guard. Prints a line for each: a hash
// of all forces, and instructions an update. HFH_SCALAR is what all of it computes in, float or double.

namespace {

using Scalar = HFH_SCALAR;
// Places are computed in Scalar too: the ground lies at the origin.
using Ground = hfh::BilinearGrid<Scalar, hfh::HeightView<std::int16_t>, Scalar>;

constexpr Ground ground{
    hfh::HeightView{microcontroller::ground.data(), microcontroller::samples, microcontroller::samples},
    {.spacing = glm::dvec2{microcontroller::cell_size}, .height_scale = microcontroller::height_unit}};
static_assert(ground.status() == hfh::GridStatus::ok);

/// What a control loop has, once a device.
struct Loop {
    hfh::ProxyTracker<Ground> tracker{ground, {.max_patches = 100, .max_contact_patches = 8}};
    hfh::ForceEvaluator<Scalar> force{.stiffness = 500, .max_force = Scalar(3.3)};
    hfh::BasicForceGuard<Scalar> guard;
};

/// The time of an update, so many milliseconds after the start.
template <hfh::Real T>
[[nodiscard]] constexpr hfh::DeviceTime<T> time_of(int milliseconds) noexcept {
    if constexpr (std::same_as<T, double>)
        return 0.001 * milliseconds;
    else
        return {std::int64_t{1'000'000} * milliseconds};
}

/// FNV-1a of the bits of what is felt.
class Hash {
public:
    template <hfh::Real T>
    void add(const hfh::vec3<T>& p) noexcept {
        for (const T x : {p.x, p.y, p.z}) add(std::bit_cast<typename hfh::detail::Bits<T>::Type>(x));
    }
    void add(std::uint64_t bits) noexcept {
        for (int byte = 0; byte < 8; ++byte, bits >>= 8) value_ = (value_ ^ (bits & 0xff)) * 0x100000001b3u;
    }
    [[nodiscard]] std::uint64_t value() const noexcept { return value_; }

private:
    std::uint64_t value_ = 0xcbf29ce484222325u;
};

/// Instructions of a part of the loop.
class Cost {
public:
    void add(std::uint32_t instructions) noexcept {
        sum_ += instructions;
        worst_ = instructions > worst_ ? instructions : worst_;
        ++updates_;
    }
    [[nodiscard]] std::uint32_t average() const noexcept { return (sum_ + updates_ / 2) / updates_; }
    [[nodiscard]] std::uint32_t worst() const noexcept { return worst_; }

private:
    std::uint32_t sum_ = 0, updates_ = 0, worst_ = 0;
};

struct Felt {
    Hash hash;
    std::uint32_t contacts = 0, trips = 0;
    Cost update, guard; ///< tracker and force; guard
};

Felt feel(const microcontroller::Stroke& stroke) noexcept {
    Felt felt;
    Loop loop;
    const std::uint32_t before = board::clock();
    const std::uint32_t clock_itself = board::instructions_between(before, board::clock());
    for (int n = 0; n < stroke.updates; ++n) {
        const microcontroller::EncoderCounts counts = stylus_of(stroke, n);
        const hfh::vec3<Scalar> stylus =
            Scalar(microcontroller::encoder_step) * hfh::vec3<Scalar>{counts.x, counts.y, counts.z};

        const std::uint32_t begin = board::clock();
        const hfh::Contact<Scalar> contact = loop.tracker.update(stylus);
        const hfh::Force<Scalar> force = loop.force(contact);
        const std::uint32_t middle = board::clock();
        const hfh::BasicGuardedForce<Scalar> guarded =
            loop.guard.update({.time = time_of<Scalar>(n), .position = stylus}, force.newtons,
                              contact.status == hfh::ContactStatus::buried);
        const std::uint32_t end = board::clock();

        felt.update.add(board::instructions_between(begin, middle) - clock_itself);
        felt.guard.add(board::instructions_between(middle, end) - clock_itself);
        felt.contacts += contact.touching();
        felt.trips += guarded.trip != hfh::GuardTrip::none;
        felt.hash.add(static_cast<std::uint64_t>(contact.status));
        felt.hash.add(force.newtons);
        felt.hash.add(guarded.newtons);
    }
    return felt;
}

/// " name number", in that base.
void print(const char* name, std::uint64_t number, unsigned base = 10) noexcept {
    char digits[24];
    char* at = digits + sizeof digits;
    *--at = '\0';
    do {
        *--at = "0123456789abcdef"[number % base];
        number /= base;
    } while (number > 0);
    board::print(" ");
    board::print(name);
    board::print(" ");
    board::print(at);
}

} // namespace

int main() {
    for (const microcontroller::Stroke& stroke : microcontroller::strokes) {
        const Felt felt = feel(stroke);
        board::print(stroke.name);
        print("hash", felt.hash.value(), 16);
        print("contacts", felt.contacts);
        print("trips", felt.trips);
        print("update", felt.update.average());
        print("worst", felt.update.worst());
        print("guard", felt.guard.average());
        print("worst_guard", felt.guard.worst());
        board::print("\n");
    }
}
