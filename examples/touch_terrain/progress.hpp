#ifndef TOUCH_TERRAIN_PROGRESS_HPP
#define TOUCH_TERRAIN_PROGRESS_HPP

#include "numbers.hpp"

#include <chrono>
#include <cstdio>

#include <unistd.h>

namespace demo {

/// One line on a terminal for those who wait longer than a second; nothing otherwise. Gone when it goes out of scope.
class Progress {
public:
    Progress() = default;
    ~Progress() {
        if (shown_) std::fputs("\r\033[K", stderr);
    }
    Progress(const Progress&) = delete;
    Progress& operator=(const Progress&) = delete;

    /// `share` of the path is done, `updates` so far. Cheap enough to be called on every update.
    void show(unsigned long long updates, double share) {
        if (!terminal_ || updates % 4096 != 0) return;
        const auto now = Clock::now();
        if (now < next_) return;
        next_ = now + std::chrono::milliseconds{250};
        std::fprintf(stderr, "\r\033[K%s updates, %.0f %%", grouped(updates).c_str(), 100 * share);
        shown_ = true;
    }

private:
    using Clock = std::chrono::steady_clock;
    bool terminal_ = ::isatty(STDERR_FILENO) == 1;
    bool shown_ = false;
    Clock::time_point next_ = Clock::now() + std::chrono::seconds{1};
};

} // namespace demo

#endif // TOUCH_TERRAIN_PROGRESS_HPP
