#include "board.hpp"
#include "control_loop.hpp"

#include <bit>
#include <cstdint>

// Replays the recorded strokes. Prints a line for each: a hash of all forces, and instructions an update.

namespace {

using microcontroller::Scalar;

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
    microcontroller::ControlLoop loop;
    const std::uint32_t before = board::clock();
    const std::uint32_t clock_itself = board::instructions_between(before, board::clock());
    for (int n = 0; n < stroke.updates; ++n) {
        const hfh::vec3<Scalar> stylus = microcontroller::stylus_at(stylus_of(stroke, n));

        const std::uint32_t begin = board::clock();
        const hfh::Contact<Scalar> contact = loop.touch(stylus);
        const hfh::vec3<Scalar> newtons = loop.push_back(contact);
        const std::uint32_t middle = board::clock();
        const hfh::BasicGuardedForce<Scalar> guarded =
            loop.guard(n, stylus, newtons, contact.status == hfh::ContactStatus::buried);
        const std::uint32_t end = board::clock();

        felt.update.add(board::instructions_between(begin, middle) - clock_itself);
        felt.guard.add(board::instructions_between(middle, end) - clock_itself);
        felt.contacts += contact.touching();
        felt.trips += guarded.trip != hfh::GuardTrip::none;
        felt.hash.add(static_cast<std::uint64_t>(contact.status));
        felt.hash.add(newtons);
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
