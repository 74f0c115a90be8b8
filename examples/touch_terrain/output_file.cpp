#include "output_file.hpp"

#include "bad_input.hpp"

#include <array>
#include <atomic>
#include <cerrno>
#include <csignal>
#include <cstring>
#include <utility>

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

namespace demo {
namespace {

[[noreturn]] void refuse(const std::filesystem::path& target) {
    throw BadInput{target.string() + " cannot be written: " + std::strerror(errno) + "."};
}

/// The names that a signal has to remove. A handler may do no more than look at atomics without locks and make system calls.
constexpr std::size_t most_files = 8;
std::array<std::atomic<const char*>, most_files> partial_names{};
static_assert(std::atomic<const char*>::is_always_lock_free);

extern "C" void remove_partial_files(int signal) {
    for (const auto& name : partial_names) {
        if (const char* const partial = name.load()) ::unlink(partial);
    }
    // SA_RESETHAND has put the default in our place: the program ends as if nobody had caught the signal.
    ::raise(signal);
}

/// `name` is removed by a signal from now on. False if there are too many.
bool register_partial(const char* name) {
    for (auto& place : partial_names) {
        const char* none = nullptr;
        if (place.compare_exchange_strong(none, name)) return true;
    }
    return false;
}

void unregister_partial(const char* name) {
    for (auto& place : partial_names) {
        const char* mine = name;
        if (place.compare_exchange_strong(mine, nullptr)) return;
    }
}

void catch_signals() {
    for (const int signal : {SIGINT, SIGHUP, SIGTERM}) {
        struct sigaction now {};
        // What was ignored when the program began (nohup) stays so.
        if (::sigaction(signal, nullptr, &now) != 0 || now.sa_handler != SIG_DFL) continue;
        struct sigaction mine {};
        mine.sa_handler = remove_partial_files;
        mine.sa_flags = static_cast<int>(SA_RESETHAND);
        sigemptyset(&mine.sa_mask);
        ::sigaction(signal, &mine, nullptr);
    }
}

bool is_standard_stream(const std::filesystem::path& target) {
    struct stat file {};
    if (::stat(target.c_str(), &file) != 0) return false;
    for (const int stream : {STDOUT_FILENO, STDERR_FILENO}) {
        struct stat open {};
        if (::fstat(stream, &open) == 0 && open.st_dev == file.st_dev && open.st_ino == file.st_ino)
            return true;
    }
    return false;
}

} // namespace

OutputFile::OutputFile(const std::filesystem::path& target) : target_{target} {
    std::error_code error;
    if (std::filesystem::exists(target, error)) {
        if (!std::filesystem::is_regular_file(target, error))
            throw BadInput{target.string() + " cannot be written: it is there and is not a regular file."};
        if (is_standard_stream(target))
            throw BadInput{target.string() + " cannot be written: what the program prints goes there."};
        target_ = std::filesystem::canonical(target); // what a link points to is replaced, not the link
    }
    partial_ = target_.string() + ".partial-" + std::to_string(::getpid());
    catch_signals();
    if (!register_partial(partial_.c_str())) {
        errno = EMFILE;
        refuse(target_);
    }
    descriptor_ = ::open(partial_.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0666);
    if (descriptor_ < 0) {
        const int why = errno;
        unregister_partial(partial_.c_str());
        errno = why;
        refuse(target_);
    }
}

OutputFile::~OutputFile() {
    if (descriptor_ >= 0) ::close(descriptor_);
    if (!kept_) ::unlink(partial_.c_str());
    unregister_partial(partial_.c_str());
}

void OutputFile::write(std::string_view text) {
    while (!text.empty()) {
        const auto written = ::write(descriptor_, text.data(), text.size());
        if (written < 0 && errno == EINTR) continue;
        if (written < 0) refuse(target_);
        text.remove_prefix(static_cast<std::size_t>(written));
    }
}

void OutputFile::keep() {
    // Some file systems say only now that there was no room.
    const int result = ::close(std::exchange(descriptor_, -1));
    if (result != 0 || ::rename(partial_.c_str(), target_.c_str()) != 0) refuse(target_);
    kept_ = true;
}

} // namespace demo
