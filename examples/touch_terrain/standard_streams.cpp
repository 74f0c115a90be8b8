#include "standard_streams.hpp"

#include "bad_input.hpp"

#include <cerrno>
#include <csignal>
#include <cstring>

#include <fcntl.h>
#include <unistd.h>

namespace demo {
namespace {

[[noreturn]] void refuse() {
    throw BadInput{std::string{"Standard output cannot be written: "} + std::strerror(errno) + "."};
}

} // namespace

void set_up_standard_streams() {
    std::signal(SIGPIPE, SIG_IGN);
    std::signal(SIGXFSZ, SIG_IGN);
    const bool closed = ::fcntl(STDOUT_FILENO, F_GETFD) < 0;
    const int why = errno;
    for (const int stream : {STDIN_FILENO, STDOUT_FILENO, STDERR_FILENO}) {
        // The lowest free number is the one that open takes.
        if (::fcntl(stream, F_GETFD) < 0) (void)::open("/dev/null", O_RDWR);
    }
    errno = why;
    if (closed) refuse();
}

void print(std::string_view text) {
    while (!text.empty()) {
        const auto written = ::write(STDOUT_FILENO, text.data(), text.size());
        if (written < 0 && errno == EINTR) continue;
        if (written < 0) refuse();
        text.remove_prefix(static_cast<std::size_t>(written));
    }
}

} // namespace demo
