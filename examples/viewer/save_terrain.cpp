#include "save_terrain.hpp"

#include "edits.hpp"

#include <bad_input.hpp>
#include <numbers.hpp>
#include <output_file.hpp>

#include <string>

namespace viewer {
namespace {

constexpr float no_data = -3.4e38f;

template <hfh::Sample S>
void write_rows(const demo::Heights<S>& heights, const hfh::GridFrame& frame, demo::OutputFile& out) {
    std::string row(static_cast<std::size_t>(heights.columns()) * sizeof(float), '\0');
    for (hfh::Index j = heights.rows(); j-- > 0;) { // north row first
        for (hfh::Index i = 0; i < heights.columns(); ++i) {
            const S sample =
                load_sample(heights.data()[i * heights.column_stride() + j * heights.row_stride()]);
            const float metres = heights.missing(sample)
                                     ? no_data
                                     : static_cast<float>(frame.height_offset +
                                                          frame.height_scale * static_cast<double>(sample));
            row.replace(static_cast<std::size_t>(i) * sizeof metres, sizeof metres,
                        reinterpret_cast<const char*>(&metres), sizeof metres);
        }
        out.write(row);
    }
}

} // namespace

void save_terrain(const demo::Terrain& terrain, const hfh::GridFrame& frame,
                  const std::filesystem::path& file) {
    if (file.extension() != ".flt")
        throw demo::BadInput{"The name to save as is " + demo::shown(file.string()) +
                             ", but must end in .flt."};
    std::filesystem::path header = file;
    header.replace_extension(".hdr");
    std::error_code none;
    for (const std::filesystem::path& there : {file, header})
        if (std::filesystem::exists(there, none))
            throw demo::BadInput{there.string() + " is there already: it is not written over."};

    demo::OutputFile samples{file}, about{header};
    std::string text;
    std::visit(
        [&](const auto& heights) {
            write_rows(heights, frame, samples);
            text = "ncols " + std::to_string(heights.columns()) + "\nnrows " +
                   std::to_string(heights.rows()) + "\n";
        },
        terrain.heights);
    const auto line = [&](const char* name, double value) {
        text += name;
        text += ' ';
        demo::append_number(text, value);
        text += '\n';
    };
    line("xdim", frame.spacing.x);
    line("ydim", frame.spacing.y);
    line("nodata", static_cast<double>(no_data));
    text += "nbits 32\npixeltype float\nbyteorder I\nlayout bil\nnbands 1\n";
    about.write(text);
    samples.keep();
    about.keep();
}

} // namespace viewer
