#include "stylus_path.hpp"

#include "bad_input.hpp"
#include "numbers.hpp"

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstring>
#include <limits>
#include <string_view>

namespace demo {

StylusPathFile::StylusPathFile(const std::filesystem::path& file)
    : file_{file}, buffer_(std::size_t{1} << 20), last_t_{-std::numeric_limits<double>::infinity()} {
    std::error_code error;
    if (std::filesystem::is_directory(file, error)) {
        throw BadInput{file.string() + " is a directory, not a path file."};
    }
    stream_.rdbuf()->pubsetbuf(buffer_.data(), static_cast<std::streamsize>(buffer_.size()));
    errno = 0;
    stream_.open(file, std::ios::binary);
    if (!stream_) throw BadInput{file.string() + " cannot be read: " + std::strerror(errno) + "."};
    if (std::filesystem::is_regular_file(file, error)) {
        size_ = static_cast<double>(std::filesystem::file_size(file, error));
    }

    constexpr std::string_view header = "t,x,y,z";
    const bool any = read_line();
    text_ = std::string{without_byte_order_mark(text_)};
    if (!any || text_ != header) {
        line_ = 1;
        refuse("the header is " + shown(text_) + ", but must be " + shown(header));
    }
}

std::optional<StylusSample> StylusPathFile::next() {
    if (!read_line()) {
        if (line_ == 1)
            throw BadInput{file_.string() + " has no row below its header, but a path needs at least one."};
        return std::nullopt;
    }
    constexpr std::array<const char*, 4> names{"t", "x", "y", "z"};
    const auto fields = static_cast<std::size_t>(std::ranges::count(text_, ',')) + 1;
    if (fields != names.size()) {
        refuse(shown(text_) + " has " + std::to_string(fields) + (fields == 1 ? " value" : " values") +
               ", but a row needs 4: t,x,y,z");
    }

    std::array<double, 4> values{};
    std::string_view rest = text_;
    for (std::size_t column = 0; column < names.size(); ++column) {
        const std::size_t end = std::min(rest.find(','), rest.size());
        const std::string_view field = trimmed(rest.substr(0, end));
        rest.remove_prefix(std::min(end + 1, rest.size()));
        const auto value = parse_finite(field);
        if (!value)
            refuse(std::string{names[column]} + " is " + shown(field) + ", but must be a finite number");
        values[column] = *value;
    }
    const double t = values[0];
    if (t < last_t_) {
        std::string before;
        append_number(before, last_t_);
        refuse("t is " + shown(trimmed(std::string_view{text_}.substr(0, text_.find(',')))) +
               ", but time must not run backwards from " + before + " in the row above");
    }
    last_t_ = t;
    return StylusSample{t, {values[1], values[2], values[3]}};
}

double StylusPathFile::progress() const noexcept { return size_ > 0 ? std::min(1.0, read_ / size_) : 0.0; }

/// The next line without its end (LF or CRLF), or false at the end of the file.
bool StylusPathFile::read_line() {
    constexpr std::size_t longest = 1000;
    char line[longest];
    stream_.getline(line, longest);
    const auto read = static_cast<std::size_t>(stream_.gcount());
    if (stream_.bad())
        throw BadInput{file_.string() + " cannot be read to its end: " + std::strerror(errno) + "."};
    if (read == 0 && stream_.eof()) {
        text_.clear();
        return false;
    }
    ++line_;
    read_ += static_cast<double>(read);
    text_.assign(line, read - (stream_.eof() || stream_.fail() ? 0 : 1));
    if (!text_.empty() && text_.back() == '\r') text_.pop_back();
    if (stream_.fail() && !stream_.eof()) refuse(shown(text_) + " is longer than any row of four numbers");
    return true;
}

void StylusPathFile::refuse(const std::string& what) const {
    throw BadInput{file_.string() + ", line " + std::to_string(line_) + ": " + what + "."};
}

} // namespace demo
