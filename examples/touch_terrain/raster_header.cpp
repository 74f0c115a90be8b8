#include "raster_header.hpp"

#include "bad_input.hpp"
#include "memory_map.hpp"
#include "numbers.hpp"

#include <algorithm>
#include <bit>
#include <cctype>
#include <map>
#include <string_view>

namespace demo {
namespace {

std::string upper(std::string_view text) {
    std::string out{text};
    for (char& c : out) c = static_cast<char>(std::toupper(static_cast<unsigned char>(c)));
    return out;
}

std::filesystem::path header_beside(std::filesystem::path raster) {
    std::error_code error;
    for (const char* extension : {".hdr", ".HDR"}) {
        raster.replace_extension(extension);
        if (std::filesystem::exists(raster, error)) return raster;
    }
    throw BadInput{raster.replace_extension(".hdr").string() +
                   " does not exist, but a raster needs its header beside it."};
}

/// The lines "KEY value" of a header, and complaints that say where.
class Entries {
public:
    explicit Entries(const std::filesystem::path& file) : file_{file} {
        const MemoryMap map{file};
        constexpr std::size_t longest = 65536;
        if (map.bytes().size() > longest) {
            throw BadInput{file.string() + " has " + std::to_string(map.bytes().size()) +
                           " bytes, but a raster header is a short text of at most " +
                           std::to_string(longest) + "."};
        }
        std::string_view rest{reinterpret_cast<const char*>(map.bytes().data()), map.bytes().size()};
        for (std::size_t line = 1; !rest.empty(); ++line) {
            const std::size_t end = std::min(rest.find('\n'), rest.size());
            add(line, trimmed(rest.substr(0, end)));
            rest.remove_prefix(std::min(end + 1, rest.size()));
        }
    }

    struct Entry {
        std::size_t line = 0;
        std::string value;
    };

    [[nodiscard]] const Entry* find(const std::string& key) const {
        const auto at = entries_.find(key);
        return at == entries_.end() ? nullptr : &at->second;
    }

    /// A whole number of at least `least`, or `otherwise` if the key is not there.
    [[nodiscard]] std::uint64_t count(const std::string& key, std::uint64_t least,
                                      std::optional<std::uint64_t> otherwise) const {
        constexpr std::uint64_t most = 0x7fff'ffff;
        const Entry* const entry = find(key);
        if (entry == nullptr) {
            if (otherwise) return *otherwise;
            throw BadInput{file_.string() + " has no " + key + ", which is needed."};
        }
        const auto value = parse_number<std::uint64_t>(entry->value);
        if (!value || *value < least || *value > most) {
            refuse(key, "a whole number from " + std::to_string(least) + " to " + std::to_string(most));
        }
        return *value;
    }

    /// One of the words allowed, as its place among them, or `otherwise` if the key is not there.
    [[nodiscard]] std::size_t choice(const std::string& key, std::initializer_list<std::string_view> words,
                                     std::size_t otherwise, const std::string& rule) const {
        const Entry* const entry = find(key);
        if (entry == nullptr) return otherwise;
        const auto at = std::ranges::find(words, upper(entry->value));
        if (at == words.end()) refuse(key, rule);
        return static_cast<std::size_t>(at - words.begin());
    }

    /// A length as --spacing takes it, if the key is there.
    [[nodiscard]] std::optional<double> length(const std::string& key) const {
        const Entry* const entry = find(key);
        if (entry == nullptr) return std::nullopt;
        const auto value = parse_finite(entry->value);
        if (!value || *value < 1e-12 || *value > 1e12)
            refuse(key, "a finite number above 0, from 1e-12 to 1e12");
        return value;
    }

    [[noreturn]] void refuse(const std::string& key, const std::string& rule) const {
        const Entry& entry = entries_.at(key);
        throw BadInput{file_.string() + ", line " + std::to_string(entry.line) + ": " + key + " is " +
                       shown(entry.value) + ", but must be " + rule + "."};
    }

private:
    void add(std::size_t line, std::string_view text) {
        if (text.empty()) return;
        const std::size_t key_end = std::min(text.find_first_of(" \t"), text.size());
        const std::string key = upper(text.substr(0, key_end));
        if (!entries_.emplace(key, Entry{line, std::string{trimmed(text.substr(key_end))}}).second) {
            throw BadInput{file_.string() + ", line " + std::to_string(line) + ": " + shown(key) +
                           " is given a second time, but each key may stand once."};
        }
    }

    std::filesystem::path file_;
    std::map<std::string, Entry> entries_;
};

void require_native_byte_order(const Entries& entries, const std::filesystem::path& file) {
    constexpr bool little = std::endian::native == std::endian::little;
    constexpr std::size_t native = little ? 0 : 1;
    const std::size_t order = entries.choice("BYTEORDER", {"I", "M", "LSBFIRST", "MSBFIRST"}, native,
                                             "I or LSBFIRST (little-endian), or M or MSBFIRST (big-endian)");
    if (order % 2 == native) return;
    const auto& entry = *entries.find("BYTEORDER");
    throw BadInput{file.string() + ", line " + std::to_string(entry.line) + ": BYTEORDER is " +
                   shown(entry.value) +
                   ", but samples are read in place and must have this machine's byte order, " +
                   (little ? "I (little-endian)." : "M (big-endian).")};
}

} // namespace

RasterHeader read_raster_header(const std::filesystem::path& raster) {
    const bool flt = upper(raster.extension().string()) == ".FLT";
    RasterHeader header;
    header.file = header_beside(raster);
    const Entries entries{header.file};

    header.rows = entries.count("NROWS", 1, std::nullopt);
    header.columns = entries.count("NCOLS", 1, std::nullopt);
    if (entries.count("NBANDS", 1, 1) != 1)
        entries.refuse("NBANDS", "1: a terrain has one height at each place");
    (void)entries.choice("LAYOUT", {"BIL", "BIP", "BSQ"}, 0, "BIL, BIP or BSQ"); // all the same for one band

    header.bits = static_cast<unsigned>(entries.count("NBITS", 1, flt ? 32 : 8));
    constexpr std::string_view sample_rule = "8 or 16 (integers), 32 (integers or floats) or 64 (floats)";
    header.kind =
        flt ? SampleKind::floating
            : static_cast<SampleKind>(entries.choice("PIXELTYPE", {"UNSIGNEDINT", "SIGNEDINT", "FLOAT"}, 0,
                                                     "UNSIGNEDINT, SIGNEDINT or FLOAT"));
    const auto is = [&](SampleKind kind, unsigned bits) {
        return header.kind == kind && header.bits == bits;
    };
    using enum SampleKind;
    if (flt && !is(floating, 32)) entries.refuse("NBITS", "32 in a .flt");
    if (header.bits != 8 && header.bits != 16 && header.bits != 32 && header.bits != 64) {
        entries.refuse("NBITS", std::string{sample_rule});
    }
    if (!is(unsigned_integer, 8) && !is(unsigned_integer, 16) && !is(signed_integer, 16) &&
        !is(signed_integer, 32) && !is(floating, 32) && !is(floating, 64)) {
        const std::string rule = "one of uint8, uint16, int16, int32, float32 and float64 together with " +
                                 std::string{entries.find("NBITS") ? "NBITS " : "the default NBITS "} +
                                 std::to_string(header.bits);
        entries.refuse(entries.find("PIXELTYPE") ? "PIXELTYPE" : "NBITS", rule);
    }
    require_native_byte_order(entries, header.file);

    header.skip = entries.count("SKIPBYTES", 0, 0);
    if (header.skip % header.sample_bytes() != 0) entries.refuse("SKIPBYTES", "a whole number of samples");
    const std::uint64_t packed = header.columns * header.sample_bytes();
    if (entries.count("BANDROWBYTES", 0, packed) != packed) {
        entries.refuse("BANDROWBYTES", std::to_string(packed) + ", NCOLS times the bytes of a sample");
    }
    header.row_bytes = packed;
    if (entries.find("TOTALROWBYTES") != nullptr) {
        header.row_bytes = entries.count("TOTALROWBYTES", 0, std::nullopt);
        if (header.row_bytes < packed || header.row_bytes % header.sample_bytes() != 0) {
            entries.refuse("TOTALROWBYTES", "a whole number of samples and at least the " +
                                                std::to_string(packed) + " bytes of a row");
        }
    }

    for (const char* key : {"NODATA", "NODATA_VALUE"}) {
        if (const auto* const entry = entries.find(key)) {
            if (!parse_number<double>(entry->value)) entries.refuse(key, "a number");
            header.no_data = entry->value;
        }
    }

    const auto cell = entries.length("CELLSIZE"), dx = entries.length("XDIM"), dy = entries.length("YDIM");
    if (cell) header.spacing = glm::dvec2{*cell};
    if (dx && dy) header.spacing = glm::dvec2{*dx, *dy};
    if (dx.has_value() != dy.has_value())
        entries.refuse(dx ? "XDIM" : "YDIM", "there together with XDIM and YDIM both");
    return header;
}

} // namespace demo
