#include "gnuplot.hpp"

#include "bad_input.hpp"

#include <cerrno>
#include <csignal>
#include <cstring>

#include <fcntl.h>
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
    char program[] = "gnuplot";
    char* const arguments[] = {program, const_cast<char*>(argument), nullptr};
    pid_t child = 0;
    const int error = ::posix_spawnp(&child, program, &actions, nullptr, arguments, environ);
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

/// Writes all of `text`, or as much as the reader wants.
void feed(int descriptor, std::string_view text) {
    const auto before = std::signal(SIGPIPE, SIG_IGN); // if gnuplot ends early, its status says so
    while (!text.empty()) {
        const auto written = ::write(descriptor, text.data(), text.size());
        if (written < 0 && errno == EINTR) continue;
        if (written < 0) break;
        text.remove_prefix(static_cast<std::size_t>(written));
    }
    std::signal(SIGPIPE, before);
}

} // namespace

void require_gnuplot() {
    const int nothing = ::open("/dev/null", O_RDWR | O_CLOEXEC);
    if (nothing < 0) return;
    struct Closer {
        int descriptor;
        ~Closer() { ::close(descriptor); }
    } const closer{nothing};
    finish(start("--version", nothing, nothing));
}

void run_gnuplot(std::string_view script, int descriptor) {
    int ends[2] = {-1, -1};
    if (::pipe2(ends, O_CLOEXEC) != 0) {
        throw BadInput{std::string{"--picture needs a pipe to gnuplot: "} + std::strerror(errno) + "."};
    }
    pid_t child = 0;
    try {
        child = start("-", ends[0], descriptor);
    } catch (...) {
        ::close(ends[0]);
        ::close(ends[1]);
        throw;
    }
    ::close(ends[0]);
    feed(ends[1], script);
    ::close(ends[1]);
    finish(child);
}

} // namespace demo
