#include "output_file.hpp"

#include "bad_input.hpp"

#include <cerrno>
#include <cstring>

#include <fcntl.h>
#include <unistd.h>

namespace demo {
namespace {

[[noreturn]] void refuse(const std::filesystem::path& target) {
    throw BadInput{target.string() + " cannot be written: " + std::strerror(errno) + "."};
}

} // namespace

OutputFile::OutputFile(const std::filesystem::path& target) : target_{target} {
    std::error_code error;
    if (std::filesystem::exists(target, error)) {
        if (!std::filesystem::is_regular_file(target, error)) {
            throw BadInput{target.string() + " cannot be written: it is there and is not a regular file."};
        }
        target_ = std::filesystem::canonical(target); // what a link points to is replaced, not the link
    }
    partial_ = target_;
    partial_ += ".partial-" + std::to_string(::getpid());
    descriptor_ = ::open(partial_.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0666);
    if (descriptor_ < 0) refuse(target_);
}

OutputFile::~OutputFile() {
    if (descriptor_ < 0) return;
    ::close(descriptor_);
    ::unlink(partial_.c_str());
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
    if (::rename(partial_.c_str(), target_.c_str()) != 0) refuse(target_);
    ::close(descriptor_);
    descriptor_ = -1;
}

} // namespace demo
