#include "catch.hpp"
#include "support/skip.hpp"
#include "touch_terrain_files.hpp"

#include <output_file.hpp>

#include <algorithm>
#include <csignal>
#include <set>

#include <fcntl.h>
#include <sys/stat.h>

// Outputs are whole or not there, whatever ends the program, and what cannot be written is an error.

using namespace touch_terrain_tests;

namespace {

bool contains(const std::string& text, const std::string& words) {
    return text.find(words) != std::string::npos;
}

/// A flat terrain and a short path over it.
class FlatFolder : public Folder {
public:
    FlatFolder() {
        samples<float>("t.bil", std::vector<float>(9, 0.0f));
        text("t.hdr", "NROWS 3\nNCOLS 3\nNBITS 32\nPIXELTYPE FLOAT\n");
        text("p.csv", "t,x,y,z\n0,1,1,1\n0.001,1,1,-0.1\n");
    }
    [[nodiscard]] std::set<std::string> names() const {
        std::set<std::string> all;
        for (const auto& [name, content] : listing()) all.insert(fs::path{name}.filename().string());
        return all;
    }
};

// No file may be larger than 4 KiB (in blocks of 512 or 1024 bytes); the default of the signal would end the program.
const std::string small_files_only = "ulimit -f 4;";

/// An output that would go where the program prints is refused, into a file and into a pipe.
void check_that_streams_are_refused(const std::string& output) {
    const FlatFolder folder;
    for (const std::string target : {"/dev/stdout", "/dev/stderr", "/dev/fd/1", "/proc/self/fd/1"}) {
        CAPTURE(target, output);
        const std::string arguments = "t.bil --path p.csv " + output + " " + target;
        const Run to_file = folder.run(arguments);
        CHECK(to_file.code == 2);
        CHECK(to_file.out.empty());
        CHECK(contains(to_file.err, target + " cannot be written: "));
        const Run to_pipe =
            folder.run_program("/bin/bash", std::string{"-c \"set -o pipefail; '"} + HFH_TOUCH_TERRAIN +
                                                "' " + arguments + " 2>&1 | cat\"");
        CHECK(to_pipe.code == 2);
        CHECK(contains(to_pipe.out, target + " cannot be written: "));
    }
}

} // namespace

TEST_CASE("touch_terrain: a record that does not fit is an error, and no file", "[touch_terrain]") {
    const FlatFolder folder;
    const auto before = folder.listing();
    const Run record = folder.run("t.bil --record out.csv", small_files_only);
    CHECK(record.code == 2);
    CHECK(contains(record.err, "out.csv cannot be written: File too large.\n"));
    CHECK(folder.listing() == before);
}

TEST_CASE("touch_terrain: a picture that does not fit is an error, and no file", "[touch_terrain]") {
    if (!hfh::test::has_program_or_skip("gnuplot")) return;
    const FlatFolder folder;
    const auto before = folder.listing();
    const Run picture = folder.run("t.bil --picture out.png", small_files_only);
    CHECK(picture.code == 2);
    CHECK(contains(picture.err, "out.png cannot be written: File too large.\n"));
    CHECK(folder.listing() == before);
}

TEST_CASE("touch_terrain: a signal that ends the program takes its unfinished files along",
          "[touch_terrain]") {
    const FlatFolder folder;
    REQUIRE(::mkfifo((folder / "fifo.csv").c_str(), 0600) == 0);
    // Open for both ends, so that the program waits for rows that never come, with its record open.
    const int fifo = ::open((folder / "fifo.csv").c_str(), O_RDWR | O_CLOEXEC);
    REQUIRE(fifo >= 0);
    const auto before = folder.names();
    for (const int signal : {SIGINT, SIGTERM, SIGHUP}) {
        for (const bool ignored : {false, true}) { // as nohup has it
            CAPTURE(signal, ignored);
            const std::string header = "t,x,y,z\n0,1,1,1\n";
            REQUIRE(::write(fifo, header.data(), header.size()) == static_cast<ssize_t>(header.size()));
            const pid_t child = ::fork();
            if (child == 0) {
                for (const int each : {SIGINT, SIGTERM, SIGHUP}) std::signal(each, SIG_DFL);
                if (ignored) std::signal(signal, SIG_IGN);
                if (::chdir((folder / "").c_str()) != 0) ::_exit(1);
                ::execl(HFH_TOUCH_TERRAIN, "touch_terrain", "t.bil", "--path", "fifo.csv", "--record",
                        "out.csv", nullptr);
                ::_exit(1);
            }
            REQUIRE(child > 0);
            const auto wait_for = [](auto&& condition) {
                for (int k = 0; k < 500 && !condition(); ++k) ::usleep(10'000);
                return condition();
            };
            CHECK(wait_for([&] { return folder.names().size() > before.size(); }));
            ::kill(child, signal);
            int status = 0;
            bool ended = false;
            const auto has_ended = [&] {
                return ended = ended || ::waitpid(child, &status, WNOHANG) == child;
            };
            if (ignored) {
                ::usleep(50'000);
                CHECK_FALSE(has_ended());
                CHECK(folder.names().size() > before.size());
                ::kill(child, signal == SIGTERM ? SIGINT : SIGTERM);
            }
            CHECK(wait_for(has_ended));
            if (!ended) ::kill(child, SIGKILL);
            CHECK(WIFSIGNALED(status));
            CHECK((ignored || WTERMSIG(status) == signal));
            CHECK(folder.names() == before);
        }
    }
    ::close(fifo);
}

TEST_CASE("touch_terrain: files that are kept stay, others go, on the same path again", "[touch_terrain]") {
    const Folder folder;
    for (int k = 0; k < 20; ++k) { // more than may be open at the same time
        demo::OutputFile dropped{folder / "a"};
        dropped.write("lost");
        demo::OutputFile kept{folder / "b"};
        kept.write(std::to_string(k));
        kept.keep();
    }
    CHECK(folder.listing().size() == 1);
    CHECK(contents(folder / "b") == "19");
}

TEST_CASE("touch_terrain: standard output that is closed, full or read by nobody is an error",
          "[touch_terrain]") {
    const FlatFolder folder;
    const auto before = folder.listing();
    const std::string program = std::string{"'"} + HFH_TOUCH_TERRAIN + "' ";
    for (const std::string where : {">&-", ">/dev/full", "| exec true"}) {
        for (const std::string arguments : {"t.bil --path p.csv --record out.csv", "--help"}) {
            CAPTURE(where, arguments);
            // The path is long enough for the other end of the pipe to be gone.
            const Run run = folder.run_program("/bin/bash", "-c \"{ sleep 0.2; " + program + arguments +
                                                                " 2>err; echo \\$? >code; } " + where + "\"");
            CHECK(contents(folder / "code") == "2\n");
            CHECK(contains(contents(folder / "err"), "touch_terrain: Standard output cannot be written: "));
            fs::remove(folder / "code");
            fs::remove(folder / "err");
            CHECK(folder.listing() == before);
        }
    }
    // Closed input and errors do no harm: no file gets the place of either.
    const Run run =
        folder.run_program("/bin/bash", "-c \"" + program + "t.bil --path p.csv --record out.csv <&- 2>&-\"");
    CHECK(run.code == 0);
    CHECK(contents(folder / "out.csv").starts_with("t,x,y,z"));
}

TEST_CASE("touch_terrain: a record does not take the place of what the program prints", "[touch_terrain]") {
    check_that_streams_are_refused("--record");
}

TEST_CASE("touch_terrain: a picture does not take the place of what the program prints", "[touch_terrain]") {
    if (hfh::test::has_program_or_skip("gnuplot")) check_that_streams_are_refused("--picture");
}

namespace {

/// `outputs` are refused for `terrain` in a sentence, and nothing changes; `free` is written.
void check_refused(const Folder& folder, const std::string& terrain, const std::vector<std::string>& outputs,
                   const std::string& free) {
    const auto before = folder.listing();
    for (const std::string& output : outputs) {
        for (const std::string option : {"--record", "--picture"}) {
            if (option == "--picture" && !hfh::test::has_program("gnuplot"))
                continue; // records are refused all the same
            const Run run = folder.run(terrain + " --device none " + option + " " + output);
            CAPTURE(terrain, option, output, run.err);
            CHECK(run.code == 2);
            CHECK(run.out.empty());
            CHECK(contains(run.err, option));
            CHECK(contains(run.err, output));
            CHECK(std::ranges::count(run.err, '\n') == 1);
            CHECK(folder.listing() == before);
        }
    }
    const Run run = folder.run(terrain + " --device none --record " + free);
    CAPTURE(terrain, free, run.err);
    CHECK(run.code == 0);
    CHECK(contents(folder / free).starts_with("t,x,y,z"));
}

} // namespace

TEST_CASE("touch_terrain: an output is refused in the place of a terrain's files, whatever their names",
          "[touch_terrain]") {
    const FlatFolder folder;
    folder.text("free.csv", "what was there before");
    fs::create_directory(folder / "other");
    fs::copy(folder / "t.bil", folder / "other/h.txt");
    fs::rename(folder / "t.hdr", folder / "other/h.hdr");
    fs::create_symlink("other/h.hdr", folder / "t.hdr");
    fs::create_symlink("t.bil", folder / "link.csv");
    fs::create_hard_link(folder / "t.bil", folder / "hard.csv");
    fs::create_symlink("t.hdr", folder / "header.csv");
    folder.text("t.prj", " ");
    folder.text("t.bil.HDR", "another");
    check_refused(folder, "t.bil",
                  {"t.bil", "./t.bil", "other/../t.bil", "link.csv", "hard.csv", "t.hdr", "header.csv",
                   "other/h.hdr", "t.prj", "t.bil.HDR"},
                  "free.csv");
    // Through a link to the terrain: what lies beside either.
    fs::create_symlink("../t.bil", folder / "other/u.bil");
    fs::create_symlink("h.hdr", folder / "other/u.hdr");
    check_refused(folder, "other/u.bil", {"t.bil", "other/u.bil", "other/h.hdr", "other/u.hdr", "t.prj"},
                  "free.csv");
    // A name that only begins in the same way is another's.
    folder.text("t2.hdr", "not of t.bil");
    check_refused(folder, "t.bil", {}, "t2.hdr");
    // Path and outputs too.
    fs::create_hard_link(folder / "p.csv", folder / "q.csv");
    CHECK(folder.run("t.bil --path p.csv --record q.csv").code == 2);
    CHECK(contents(folder / "p.csv").starts_with("t,x,y,z\n0,1,1,1"));
}

TEST_CASE("touch_terrain: an output is refused in the place of the bundled terrain", "[touch_terrain]") {
    const FlatFolder folder;
    const std::string bundled = HFH_SOURCE_DIR "/examples/data/spanish_peaks.png";
    const std::string before = contents(bundled);
    fs::create_symlink(bundled, folder / "out.csv");
    const Run run = folder.run("--path p.csv --record out.csv");
    CHECK(run.code == 2);
    const bool kept = contents(bundled) == before;
    CHECK(kept);
    if (!kept) std::ofstream{bundled, std::ios::binary} << before;
}

#ifdef TOUCH_TERRAIN_HAS_GDAL

TEST_CASE("touch_terrain gdal: an output is refused in the place of a virtual raster's sources",
          "[touch_terrain][gdal]") {
    const FlatFolder folder;
    const std::string grid = "ncols 2\nnrows 2\nxllcorner 0\nyllcorner 0\ncellsize 1\n1 2\n3 4\n";
    fs::create_directory(folder / "deep");
    folder.text("deep/a.asc", grid);
    folder.text("deep/mask.asc", grid);
    folder.text("free.csv", "what was there before");
    const auto raster = [](const std::string& source, const std::string& mask = "") {
        const auto band = [](const std::string& file, const std::string& attributes,
                             const std::string& type) {
            return "<VRTRasterBand dataType=\"" + type + "\"" + attributes +
                   "><SimpleSource><SourceFilename relativeToVRT=\"1\">" + file +
                   "</SourceFilename><SourceBand>1</SourceBand></SimpleSource></VRTRasterBand>";
        };
        return "<VRTDataset rasterXSize=\"2\" rasterYSize=\"2\">" + band(source, " band=\"1\"", "Int32") +
               (mask.empty() ? "" : "<MaskBand>" + band(mask, "", "Byte") + "</MaskBand>") + "</VRTDataset>";
    };
    folder.text("deep/inner.xml", raster("a.asc", "mask.asc"));
    folder.text("t.vrt", raster("deep/inner.xml"));
    folder.text("t.vrt.aux.xml", "<PAMDataset/>");
    fs::create_symlink("deep/a.asc", folder / "a.csv");
    check_refused(folder, "t.vrt",
                  {"t.vrt", "deep/inner.xml", "deep/a.asc", "deep/mask.asc", "a.csv", "t.vrt.aux.xml"},
                  "free.csv");
    // A source by a name that is more than that of a file.
    folder.text("u.vrt", raster("/vsisubfile/0," + (folder / "deep/a.asc").string()));
    check_refused(folder, "u.vrt", {"u.vrt", "deep/a.asc"}, "free.csv");
}

TEST_CASE("touch_terrain gdal: an output is refused in the place of the file that holds the terrain",
          "[touch_terrain][gdal]") {
    const FlatFolder folder;
    folder.text("a.asc", "ncols 2\nnrows 2\nxllcorner 0\nyllcorner 0\ncellsize 1\n1 2\n3 4\n");
    folder.text("free.csv", "what was there before");
    fs::create_symlink("a.asc", folder / "link.csv");
    const std::string here = (folder / "a.asc").string();
    check_refused(folder, "/vsisubfile/0,a.asc", {"a.asc", here, "link.csv"}, "free.csv");
    check_refused(folder, "/vsisubfile/0," + here, {"a.asc", "link.csv"}, "free.csv");

    // An archive: one stored file and the list of it.
    const std::string data = contents(folder / "a.asc");
    const std::string zip = zip_of("b.asc", data);
    folder.text("z.zip", zip);
    fs::create_directory(folder / "dir");
    folder.text("dir/z.zip", zip);
    folder.text("b.asc", "what was there before");
    for (const std::string name : {"/vsizip/z.zip/b.asc", "/vsizip/z.zip", "/vsizip/{z.zip}/b.asc",
                                   "/vsizip/./z.zip/b.asc", "/vsisubfile/0,/vsizip/z.zip/b.asc"})
        check_refused(folder, "'" + name + "'", {"z.zip", "dir/../z.zip"}, "free.csv");
    check_refused(folder, "/vsizip/dir/z.zip/b.asc", {"dir/z.zip"},
                  "b.asc"); // another b.asc than that inside
}

TEST_CASE("touch_terrain gdal: an output is refused in the place of a database of rasters",
          "[touch_terrain][gdal]") {
    if (!hfh::test::has_program_or_skip("gdal_translate")) return;
    const FlatFolder folder;
    folder.text("a.asc", "ncols 2\nnrows 2\nxllcorner 0\nyllcorner 0\ncellsize 1\n1 2\n3 4\n");
    folder.text("free.csv", "what was there before");
    if (folder
            .run_program("/bin/sh",
                         "-c 'gdal_translate -q -ot Float32 -a_srs EPSG:3857 -of GPKG a.asc g.gpkg'")
            .code != 0)
        return hfh::test::skip("this GDAL writes no GeoPackage");
    check_refused(folder, "g.gpkg", {"g.gpkg"}, "free.csv");
    check_refused(folder, "GPKG:g.gpkg:g", {"g.gpkg", "./g.gpkg"}, "free.csv");
    check_refused(folder, "'GPKG:" + (folder / "g.gpkg").string() + ":g'", {"g.gpkg"}, "free.csv");
}

#endif // TOUCH_TERRAIN_HAS_GDAL

TEST_CASE("touch_terrain: a pipe or a device is no terrain, and nobody waits for it", "[touch_terrain]") {
    const FlatFolder folder;
    for (const std::string name : {"a.png", "a.bil", "a.flt", "a.tif", "a.hdr", "t.prj"})
        REQUIRE(::mkfifo((folder / name).c_str(), 0600) == 0);
    for (const std::string file : {"a.png", "a.bil", "a.flt", "a.tif", "/dev/zero", "/dev/null", "t.bil"}) {
        CAPTURE(file);
        // Stopped after a while, with another code, if it waits.
        const Run run = folder.run_program("/usr/bin/timeout", std::string{"5 '"} + HFH_TOUCH_TERRAIN + "' " +
                                                                   file + " --device none");
        if (file == "t.bil") fs::remove(folder / "t.prj");
        CHECK(run.code == 2);
        CHECK((contains(run.err, "a regular file")));
    }
}

TEST_CASE("touch_terrain: positions that were refused are in the summary", "[touch_terrain]") {
    const FlatFolder folder;
    folder.text("far.csv", "t,x,y,z\n0,1,1,1\n1,1e300,1,1\n2,1,1e300,1\n3,1,1,1\n");
    const Run run = folder.run("t.bil --path far.csv");
    CHECK(run.code == 0);
    CHECK(contains(run.out, "\nrefused         2 positions "));
    CHECK_FALSE(contains(folder.run("t.bil --path p.csv").out, "refused"));
}

TEST_CASE("touch_terrain: a byte-order mark in front of a path is read over", "[touch_terrain]") {
    const FlatFolder folder;
    folder.text("bom.csv", "\xef\xbb\xbft,x,y,z\n0,1,1,1\n0.001,1,1,-0.1\n");
    CHECK(folder.run("t.bil --path bom.csv --record out.csv").code == 0);
    CHECK(folder.run("t.bil --path p.csv --record other.csv").code == 0);
    CHECK(contents(folder / "out.csv") == contents(folder / "other.csv"));
    folder.text("twice.csv", "\xef\xbb\xbf\xef\xbb\xbft,x,y,z\n0,1,1,1\n");
    CHECK(folder.run("t.bil --path twice.csv").code == 2);
}

TEST_CASE("touch_terrain: the built-in stroke gets over walls without pressing against them",
          "[touch_terrain]") {
    // Two boxes on a floor, as a depth camera sees them: walls a third as high as the ground is wide.
    constexpr int columns = 128, rows = 96;
    std::vector<std::int16_t> heights(columns * rows, 0);
    for (int j = 0; j < rows; ++j) {
        for (int i = 0; i < columns; ++i) {
            const bool first =
                i > 25 && i < 60 && j > 20 && j<75, second = i> 80 && i < 105 && j > 30 && j < 60;
            heights[static_cast<std::size_t>(j * columns + i)] = first ? 400 : second ? 300 : 0;
        }
    }
    const Folder folder;
    folder.samples("t.bil", heights);
    folder.text("t.hdr", "NROWS 96\nNCOLS 128\nNBITS 16\nPIXELTYPE SIGNEDINT\nXDIM 9.5\nYDIM 9.5\n");
    for (const std::string device : {"touch", "premium"}) {
        CAPTURE(device);
        const Run run = folder.run("t.bil --unit mm --device " + device);
        CHECK(contains(run.out, "\nguard           clamped 0 updates"));
        const double contact = std::stod(run.out.substr(run.out.find("in contact") + 16));
        CHECK(contact > 60);
    }
}

TEST_CASE("touch_terrain: the built-in stroke gets over the walls of a depth camera's scan",
          "[touch_terrain][real]") {
    const auto scan = hfh::test::shared_file_or_skip("kinect_boxes.bil");
    if (!scan) return;
    const Run run = Folder{}.run("'" + *scan + "' --unit mm");
    CHECK(contains(run.out, "every 0.0019 x 0.0019 m"));
    CHECK(contains(run.out, "\nguard           clamped 0 updates"));
}
