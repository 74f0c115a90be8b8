#include "raster_header.hpp"

#include "bad_input.hpp"
#include "memory_map.hpp"
#include "no_data.hpp"
#include "numbers.hpp"

#include <algorithm>
#include <array>
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

/// All keys that mean something here. Whatever else a line begins with, the line is a comment.
constexpr std::array<std::string_view, 20> known_keys{
    "NROWS",     "NCOLS",     "NBANDS",       "LAYOUT",        "NBITS",     "PIXELTYPE",    "DATATYPE",
    "BYTEORDER", "SKIPBYTES", "BANDROWBYTES", "TOTALROWBYTES", "NODATA",    "NODATA_VALUE", "NODATAVALUE",
    "CELLSIZE",  "XDIM",      "YDIM",         "ULYMAP",        "YLLCORNER", "YLLCENTER"};

/// The text of a header without a byte-order mark.
std::string text_of(const std::filesystem::path& file) {
    const MemoryMap map{file};
    constexpr std::size_t longest = 65536;
    if (map.bytes().size() > longest) {
        throw BadInput{file.string() + " has " + std::to_string(map.bytes().size()) +
                       " bytes, but a raster header is a short text of at most " + std::to_string(longest) +
                       "."};
    }
    const std::string_view text{reinterpret_cast<const char*>(map.bytes().data()), map.bytes().size()};
    return std::string{without_byte_order_mark(text)};
}

/// The lines "KEY value" of a header, and complaints that say where.
class Entries {
public:
    explicit Entries(const std::filesystem::path& file) : file_{file} {
        const std::string text = text_of(file);
        std::string_view rest = text;
        for (std::size_t line = 1; !rest.empty(); ++line) {
            const std::size_t end = std::min(rest.find_first_of("\r\n"), rest.size());
            add(line, trimmed(rest.substr(0, end)));
            rest.remove_prefix(end);
            rest.remove_prefix(rest.starts_with("\r\n") ? 2 : std::min<std::size_t>(1, rest.size()));
        }
    }

    struct Entry {
        std::size_t line = 0;
        std::string key; ///< as written
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

    /// A finite number, if the key is there.
    [[nodiscard]] std::optional<double> number(const std::string& key) const {
        const Entry* const entry = find(key);
        if (entry == nullptr) return std::nullopt;
        const auto value = parse_finite(entry->value);
        if (!value) refuse(key, "a finite number");
        return value;
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
        const std::string written{text.substr(0, key_end)}, key = upper(written);
        if (std::ranges::find(known_keys, key) == known_keys.end()) return;
        if (!entries_.emplace(key, Entry{line, written, std::string{trimmed(text.substr(key_end))}}).second) {
            throw BadInput{file_.string() + ", line " + std::to_string(line) + ": " + shown(key) +
                           " is given a second time, but each key may stand once."};
        }
    }

    std::filesystem::path file_;
    std::map<std::string, Entry> entries_;
};

/// The kind of a sample where no PIXELTYPE says it: ESRI's default are integers without a sign, but who marks "no data" by
/// a negative number has some with a sign (as GDAL has it too, though only from 16 bits on).
SampleKind kind_assumed(const Entries& entries, RasterHeader& header) {
    const std::string name = header.file.filename().string();
    if (const auto* const other = entries.find("DATATYPE")) {
        throw BadInput{header.file.string() + ", line " + std::to_string(other->line) + ": " + other->key +
                       " is " + shown(other->value) +
                       ", but what a sample is must stand in PIXELTYPE, UNSIGNEDINT, SIGNEDINT or FLOAT."};
    }
    if (header.bits == 64) {
        throw BadInput{
            header.file.string() +
            " has no PIXELTYPE, but samples of 64 bits are read as FLOAT alone, which must stand there."};
    }
    const auto no_data = parse_number<double>(header.no_data);
    if (no_data && *no_data < 0) {
        header.assumed.push_back(sign_assumed(name, header.no_data));
        return SampleKind::signed_integer;
    }
    header.assumed.push_back("samples are integers without a sign, for " + name + " has no PIXELTYPE");
    return SampleKind::unsigned_integer;
}

bool is_swapped(const Entries& entries) {
    constexpr std::size_t native = std::endian::native == std::endian::little ? 0 : 1;
    const std::size_t order = entries.choice("BYTEORDER", {"I", "M", "LSBFIRST", "MSBFIRST"}, native,
                                             "I or LSBFIRST (little-endian), or M or MSBFIRST (big-endian)");
    return order % 2 != native;
}

void read_no_data(const Entries& entries, RasterHeader& header) {
    for (const char* key : {"NODATAVALUE", "NODATA", "NODATA_VALUE"}) {
        const auto* const entry = entries.find(key);
        if (entry == nullptr) continue;
        if (!parse_number<double>(entry->value)) entries.refuse(key, "a number");
        header.no_data = entry->value;
    }
    const auto* const odd = entries.find("NODATAVALUE");
    if (odd != nullptr && header.no_data == odd->value) {
        header.assumed.push_back(odd->key + " in " + header.file.filename().string() + " is meant as NODATA");
    }
}

void read_placement(const Entries& entries, RasterHeader& header) {
    const auto cell = entries.length("CELLSIZE"), dx = entries.length("XDIM"), dy = entries.length("YDIM");
    if (cell) header.cell = glm::dvec2{*cell};
    if (dx && dy) header.cell = glm::dvec2{*dx, *dy};
    if (dx.has_value() != dy.has_value())
        entries.refuse(dx ? "XDIM" : "YDIM", "there together with XDIM and YDIM both");
    if (!header.cell) return;
    const double height = static_cast<double>(header.rows - 1) * header.cell->y;
    if (const auto corner = entries.number("YLLCORNER"))
        header.north = *corner + 0.5 * header.cell->y + height;
    if (const auto center = entries.number("YLLCENTER")) header.north = *center + height;
    if (const auto top = entries.number("ULYMAP")) header.north = *top;
}

} // namespace

std::filesystem::path header_beside(const std::filesystem::path& raster) {
    std::error_code error;
    for (const char* extension : {".hdr", ".HDR"}) {
        auto header = raster;
        header.replace_extension(extension);
        if (std::filesystem::exists(header, error)) return header;
        header = raster;
        header += extension;
        if (std::filesystem::exists(header, error)) return header;
    }
    auto wanted = raster;
    throw BadInput{wanted.replace_extension(".hdr").string() +
                   " does not exist, but a raster needs its header beside it."};
}

bool is_envi_header(const std::filesystem::path& header) {
    const std::string text = text_of(header);
    const auto first = std::string_view{text}.substr(0, text.find_first_of(" \t\r\n"));
    return first == "ENVI";
}

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
    if (flt && header.bits != 32) entries.refuse("NBITS", "32 in a .flt");
    if (header.bits != 8 && header.bits != 16 && header.bits != 32 && header.bits != 64)
        entries.refuse("NBITS", std::string{sample_rule});
    read_no_data(entries, header);
    if (flt) {
        header.kind = SampleKind::floating;
    } else if (entries.find("PIXELTYPE") == nullptr) {
        header.kind = kind_assumed(entries, header);
    } else {
        header.kind = static_cast<SampleKind>(entries.choice(
            "PIXELTYPE", {"UNSIGNEDINT", "SIGNEDINT", "FLOAT"}, 0, "UNSIGNEDINT, SIGNEDINT or FLOAT"));
    }
    const auto is = [&](SampleKind kind, unsigned bits) {
        return header.kind == kind && header.bits == bits;
    };
    using enum SampleKind;
    if (!is(unsigned_integer, 8) && !is(unsigned_integer, 16) && !is(unsigned_integer, 32) &&
        !is(signed_integer, 8) && !is(signed_integer, 16) && !is(signed_integer, 32) && !is(floating, 32) &&
        !is(floating, 64)) {
        entries.refuse(
            "PIXELTYPE",
            "one of uint8, uint16, uint32, int8, int16, int32, float32 and float64 together with " +
                std::string{entries.find("NBITS") ? "NBITS " : "the default NBITS "} +
                std::to_string(header.bits));
    }
    header.swapped = is_swapped(entries);

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

    read_placement(entries, header);
    return header;
}

} // namespace demo
