#ifndef HFH_TESTS_SUPPORT_WATCHDOG_HPP
#define HFH_TESTS_SUPPORT_WATCHDOG_HPP

#include <csignal>
#include <cstdlib>
#include <cstring>

#include <unistd.h>

namespace hfh::test {

/// Ends the program if what it watches over does not end: an endless loop in a test is a failure with a name, and not a
/// build that hangs. One at a time.
class Watchdog {
public:
    /// `what` is a literal: the last words.
    explicit Watchdog(const char* what, unsigned seconds = 20) : before_{std::signal(SIGALRM, bark)} {
        told() = what;
        alarm(seconds);
    }
    ~Watchdog() {
        alarm(0);
        std::signal(SIGALRM, before_);
    }
    Watchdog(const Watchdog&) = delete;
    Watchdog& operator=(const Watchdog&) = delete;

private:
    static const char*& told() {
        static const char* what = "";
        return what;
    }
    static void bark(int) {
        constexpr char before[] = "does not return: ";
        (void)!write(STDERR_FILENO, before, sizeof before - 1);
        (void)!write(STDERR_FILENO, told(), std::strlen(told()));
        (void)!write(STDERR_FILENO, "\n", 1);
        std::abort();
    }
    void (*before_)(int);
};

} // namespace hfh::test

#endif // HFH_TESTS_SUPPORT_WATCHDOG_HPP
