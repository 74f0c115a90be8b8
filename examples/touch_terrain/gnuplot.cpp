#include "gnuplot.hpp"

#include "bad_input.hpp"

#include <array>
#include <cerrno>
#include <csignal>
#include <cstring>
#include <utility>

#include <fcntl.h>
#include <poll.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

extern char** environ; // NOLINT: POSIX has it nowhere else

namespace demo {
namespace {

/// gnuplot, reading from `input`, writing to `output`, silent.
pid_t start(const char* argument, int input, int output) {
    posix_spawn_file_actions_t actions;
    posix_spawn_file_actions_init(&actions);
    posix_spawn_file_actions_adddup2(&actions, input, STDIN_FILENO);
    posix_spawn_file_actions_adddup2(&actions, output, STDOUT_FILENO);
    posix_spawn_file_actions_addopen(&actions, STDERR_FILENO, "/dev/null", O_WRONLY, 0);
    // What the program itself ignores would be ignored by its child.
    posix_spawnattr_t attributes;
    posix_spawnattr_init(&attributes);
    sigset_t signals;
    sigemptyset(&signals);
    sigaddset(&signals, SIGPIPE);
    sigaddset(&signals, SIGXFSZ);
    posix_spawnattr_setsigdefault(&attributes, &signals);
    posix_spawnattr_setflags(&attributes, POSIX_SPAWN_SETSIGDEF);
    char program[] = "gnuplot";
    char* const arguments[] = {program, const_cast<char*>(argument), nullptr};
    pid_t child = 0;
    const int error = ::posix_spawnp(&child, program, &actions, &attributes, arguments, environ);
    posix_spawnattr_destroy(&attributes);
    posix_spawn_file_actions_destroy(&actions);
    if (error != 0) {
        throw BadInput{std::string{"--picture needs gnuplot, which cannot be started: "} +
                       std::strerror(error) + "."};
    }
    return child;
}

void finish(pid_t child) {
    int status = 0;
    while (::waitpid(child, &status, 0) < 0 && errno == EINTR) {
    }
    if (WIFEXITED(status) && WEXITSTATUS(status) == 0) return;
    if (WIFEXITED(status) && WEXITSTATUS(status) == 127) {
        throw BadInput{"--picture needs gnuplot, which is not on the PATH."};
    }
    throw BadInput{"--picture needs gnuplot with its pngcairo terminal, but gnuplot failed to draw."};
}

/// A descriptor that is closed when it goes out of scope.
class Descriptor {
public:
    explicit Descriptor(int number = -1) : number_{number} {}
    ~Descriptor() { close(); }
    Descriptor(const Descriptor&) = delete;
    Descriptor& operator=(const Descriptor&) = delete;
    [[nodiscard]] int get() const noexcept { return number_; }
    void close() {
        if (number_ >= 0) ::close(std::exchange(number_, -1));
    }

private:
    int number_;
};

struct Pipe {
    Pipe() : Pipe{make()} {}
    Descriptor out, in; ///< where it is read and where it is written

private:
    explicit Pipe(std::array<int, 2> ends) : out{ends[0]}, in{ends[1]} {}
    static std::array<int, 2> make() {
        std::array<int, 2> ends{-1, -1};
        if (::pipe2(ends.data(), O_CLOEXEC) == 0) return ends;
        throw BadInput{std::string{"--picture needs a pipe to gnuplot: "} + std::strerror(errno) + "."};
    }
};

/// Writes `text` to `in` and reads `out` to its end, whichever is ready: neither side may wait for the other for ever.
std::string exchange_text(Descriptor& in, std::string_view text, const Descriptor& out) {
    std::string answer;
    std::array<char, 65536> buffer{};
    ::fcntl(in.get(), F_SETFL, O_NONBLOCK);
    for (;;) {
        if (text.empty()) in.close();
        std::array<pollfd, 2> ends{pollfd{out.get(), POLLIN, 0}, pollfd{in.get(), POLLOUT, 0}};
        if (::poll(ends.data(), ends.size(), -1) < 0) continue; // interrupted
        if (ends[1].revents != 0) {
            const auto written = ::write(in.get(), text.data(), text.size());
            // If gnuplot ends early, its status says so.
            if (written < 0 && errno != EINTR && errno != EAGAIN) text = {};
            if (written > 0) text.remove_prefix(static_cast<std::size_t>(written));
        }
        if (ends[0].revents != 0) {
            const auto got = ::read(out.get(), buffer.data(), buffer.size());
            if (got == 0 || (got < 0 && errno != EINTR)) return answer;
            if (got > 0) answer.append(buffer.data(), static_cast<std::size_t>(got));
        }
    }
}

} // namespace

void require_gnuplot() {
    const Descriptor nothing{::open("/dev/null", O_RDWR | O_CLOEXEC)};
    if (nothing.get() >= 0) finish(start("--version", nothing.get(), nothing.get()));
}

std::string run_gnuplot(std::string_view script) {
    Pipe to, from;
    const pid_t child = start("-", to.out.get(), from.in.get());
    to.out.close();
    from.in.close();
    std::string answer = exchange_text(to.in, script, from.out);
    finish(child);
    return answer;
}

} // namespace demo
