#include "catch.hpp"
#include "support/skip.hpp"
#include "touch_terrain_files.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <sstream>
#include <utility>

// The record, checked from outside: this file knows the format, Eq. (1) and section 3 of the design, and no code of
// the library or the demo.

using namespace touch_terrain_tests;

namespace {

constexpr double dx = 73.596, dy = 92.491;

/// The bundled terrain through libpng's simplified interface: alpha in whole metres, row 0 north.
class Peaks {
public:
    Peaks() {
        png_image image{};
        image.version = PNG_IMAGE_VERSION;
        REQUIRE(png_image_begin_read_from_file(&image, HFH_SOURCE_DIR "/examples/data/spanish_peaks.png") !=
                0);
        image.format = PNG_FORMAT_LINEAR_RGB_ALPHA; // leaves alpha as it is
        columns_ = image.width;
        rows_ = image.height;
        pixels_.resize(4 * columns_ * rows_);
        REQUIRE(png_image_finish_read(&image, nullptr, pixels_.data(), 0, nullptr) != 0);
    }
    [[nodiscard]] double sample(std::size_t i, std::size_t j) const {
        return pixels_[4 * ((rows_ - 1 - j) * columns_ + i) + 3];
    }
    /// Eq. (1) with the spacing kept.
    [[nodiscard]] double height(double x, double y) const {
        const double u = x / dx, v = y / dy;
        const auto i = std::min(static_cast<std::size_t>(std::max(0.0, u)), columns_ - 2);
        const auto j = std::min(static_cast<std::size_t>(std::max(0.0, v)), rows_ - 2);
        const double s = u - static_cast<double>(i), t = v - static_cast<double>(j);
        return std::lerp(std::lerp(sample(i, j), sample(i + 1, j), s),
                         std::lerp(sample(i, j + 1), sample(i + 1, j + 1), s), t);
    }

private:
    std::size_t columns_ = 0, rows_ = 0;
    std::vector<png_uint_16> pixels_;
};

struct Row {
    double t;
    std::array<double, 3> stylus, proxy, normal, force;
    bool contact;
    int patches;
    std::string status, guard;
};

std::vector<Row> rows_of(const std::string& record) {
    std::istringstream lines{record};
    std::string line;
    std::getline(lines, line);
    CHECK(line == "t,x,y,z,contact,px,py,pz,nx,ny,nz,fx,fy,fz,patches,status,guard");
    std::vector<Row> rows;
    while (std::getline(lines, line)) {
        std::istringstream fields{line};
        std::array<double, 15> n{};
        std::string field;
        for (double& value : n) {
            std::getline(fields, field, ',');
            value = std::stod(field);
        }
        std::string status, guard;
        std::getline(fields, status, ',');
        std::getline(fields, guard);
        rows.push_back({n[0],
                        {n[1], n[2], n[3]},
                        {n[5], n[6], n[7]},
                        {n[8], n[9], n[10]},
                        {n[11], n[12], n[13]},
                        n[4] == 1,
                        static_cast<int>(n[14]),
                        status,
                        guard});
    }
    return rows;
}

double distance(const std::array<double, 3>& a, const std::array<double, 3>& b) {
    return std::hypot(a[0] - b[0], a[1] - b[1], a[2] - b[2]);
}

/// How fast the distance from stylus to surface falls, at most, on the way from the proxy in any of 16 directions:
/// metres per metre. Its second-order part is about step / depth, 1e-4 at a depth of 1 m.
double steepest_descent(const Peaks& peaks, const Row& row) {
    constexpr double step = 1e-4;
    double steepest = 0;
    for (int k = 0; k < 16; ++k) {
        const double turn = 2 * 3.14159265358979 * k / 16;
        const double x = row.proxy[0] + step * std::cos(turn), y = row.proxy[1] + step * std::sin(turn);
        const double fall =
            distance(row.proxy, row.stylus) - distance({x, y, peaks.height(x, y)}, row.stylus);
        steepest = std::max(steepest, fall / step);
    }
    return steepest;
}

/// The path in a record: its first four columns.
std::string path_in(const std::string& record) {
    std::istringstream lines{record};
    std::string line, path;
    while (std::getline(lines, line)) {
        std::size_t end = 0;
        for (int k = 0; k < 4; ++k) end = line.find(',', end + 1);
        path += line.substr(0, end) + "\n";
    }
    return path;
}

} // namespace

TEST_CASE("touch_terrain: the record of the built-in stroke holds from outside", "[touch_terrain][law]") {
    const Folder folder;
    const bool in_float = GENERATE(false, true);
    CAPTURE(in_float);
    const Run run = folder.run(std::string{"--device none --stiffness 0.1 --record out.csv"} +
                               (in_float ? " --float" : ""));
    REQUIRE(run.code == 0);
    CHECK(run.err.empty());

    // World coordinates are up to 27 km: a rounding is 4e-12 m in double, 2e-3 m in float, and slopes are up to 1.3.
    const double metres = in_float ? 1e-2 : 1e-10;
    const Peaks peaks;
    const auto rows = rows_of(contents(folder / "out.csv"));
    REQUIRE(rows.size() == 20000);
    std::size_t touching = 0;
    double off_surface = 0, wrong_force = 0, largest_force = 0, buried = 0, descent = 0, backwards = 0,
           not_unit = 0;
    for (std::size_t k = 0; k < rows.size(); ++k) {
        const Row& row = rows[k];
        if (k > 0) backwards = std::max(backwards, rows[k - 1].t - row.t);
        CHECK(row.patches >= 1);
        CHECK(row.contact == (row.status == "contact"));
        CHECK(row.guard == "none"); // there is none without a device
        for (std::size_t axis = 0; axis < 3; ++axis) {
            wrong_force =
                std::max(wrong_force, std::abs(row.force[axis] - 0.1 * (row.proxy[axis] - row.stylus[axis])));
        }
        largest_force = std::max(largest_force, distance(row.force, {0, 0, 0}));
        if (row.contact) {
            ++touching;
            off_surface =
                std::max(off_surface, std::abs(row.proxy[2] - peaks.height(row.proxy[0], row.proxy[1])));
            if (!in_float) descent = std::max(descent, steepest_descent(peaks, row));
            not_unit = std::max(not_unit, std::abs(distance(row.normal, {0, 0, 0}) - 1));
        } else {
            buried = std::max(buried, peaks.height(row.stylus[0], row.stylus[1]) - row.stylus[2]);
        }
    }
    CHECK(touching > 18000);
    CHECK_FALSE(rows.front().contact);
    CHECK_FALSE(rows.back().contact);
    CHECK(largest_force > 1.0);
    CHECK(largest_force < 3.3);
    CHECK(backwards <= 0);
    CHECK(off_surface <= metres);
    CHECK(wrong_force <= 0.1 * metres);
    CHECK(buried <= metres); // never free while below the surface
    CHECK(descent <= 2e-4);  // no way further down from the proxy
    CHECK(not_unit <= (in_float ? 1e-6 : 1e-14));
}

TEST_CASE("touch_terrain: a simulated device closes the loop", "[touch_terrain][law]") {
    const Folder folder;
    const Peaks peaks;
    const Run run = folder.run("--record out.csv");
    REQUIRE(run.code == 0);
    CHECK(run.out.find("Touch, simulated") != std::string::npos);
    const auto rows = rows_of(contents(folder / "out.csv"));
    REQUIRE(rows.size() == 20000);
    CHECK_FALSE(rows.front().contact);
    CHECK_FALSE(rows.back().contact);
    std::size_t touching = 0;
    double least = 1e300, most = 0, largest_force = 0, buried = 0, off_surface = 0, descent = 0;
    for (const Row& row : rows) {
        const double height = peaks.height(row.stylus[0], row.stylus[1]);
        const double force = distance(row.force, {0, 0, 0});
        largest_force = std::max(largest_force, force);
        if (!row.contact) {
            buried = std::max(buried, height - row.stylus[2]);
            continue;
        }
        ++touching;
        off_surface =
            std::max(off_surface, std::abs(row.proxy[2] - peaks.height(row.proxy[0], row.proxy[1])));
        descent = std::max(descent, steepest_descent(peaks, row));
        const double depth = distance(row.proxy, row.stylus);
        if (depth > 1 && row.guard == "none") {
            least = std::min(least, force / depth);
            most = std::max(most, force / depth);
        }
    }
    CHECK(touching > 18000);
    CHECK(buried <= 1e-10);
    CHECK(off_surface <= 1e-10);
    CHECK(descent <= 2e-4);
    CHECK(largest_force > 1.0);
    CHECK(largest_force < 3.3);
    CHECK(most / least < 1 + 1e-9);   // one stiffness: 500 N/m in the hand
    const double scale = least / 500; // metres in the hand per metre of terrain
    // The path fills the Touch's 160 x 70 mm.
    double west = 1e300, east = -1e300, south = 1e300, north = -1e300;
    for (const Row& row : rows) {
        west = std::min(west, row.stylus[0]), east = std::max(east, row.stylus[0]);
        south = std::min(south, row.stylus[1]), north = std::max(north, row.stylus[1]);
        for (std::size_t axis = 0; axis < 3; ++axis) { // the encoder's steps, all counted from the first
            const double steps = (row.stylus[axis] - rows[0].stylus[axis]) * scale / 0.055e-3;
            if (std::abs(steps - std::round(steps)) > 1e-6) FAIL("between two steps at t = " << row.t);
        }
    }
    CHECK(std::max((east - west) * scale / 0.160, (north - south) * scale / 0.070) > 0.8);
    CHECK((east - west) * scale < 0.160);
    CHECK((north - south) * scale < 0.070);

    // The path alone, without a device, gives the same forces but for what the guard did.
    folder.text("path.csv", path_in(contents(folder / "out.csv")));
    char stiffness[40];
    std::snprintf(stiffness, sizeof stiffness, "%.17g", least);
    REQUIRE(folder.run(std::string{"--path path.csv --record again.csv --stiffness "} + stiffness).code == 0);
    const auto again = rows_of(contents(folder / "again.csv"));
    REQUIRE(again.size() == rows.size());
    for (std::size_t k = 0; k < rows.size(); ++k) {
        const bool same = distance(again[k].force, rows[k].force) <= 1e-9;
        if (rows[k].guard == "none" && !same) FAIL("another force at t = " << rows[k].t);
    }
}

TEST_CASE("touch_terrain: what a simulated device holds has been through a guard", "[touch_terrain][law]") {
    struct Device {
        std::string name, shown;
        double stiffness, max_force, max_slew; // N/m, N, N an update
    };
    const auto device =
        GENERATE(Device{"touch", "Touch", 500, 3.3, 1}, Device{"premium", "Premium 1.5", 800, 8.5, 1});
    // As hard as the device can, and far harder: it bounces, and all limits act.
    const double hardness = GENERATE(1.0, 200.0);
    const bool in_float = GENERATE(false, true);
    const double stiffness = hardness * device.stiffness;
    CAPTURE(device.name, hardness, in_float);
    const Folder folder;
    const Run run = folder.run("--device " + device.name + " --stiffness " + std::to_string(stiffness) +
                               " --record out.csv" + (in_float ? " --float" : ""));
    REQUIRE(run.code == 0);
    CHECK(run.out.find(device.shown + ", simulated") != std::string::npos);
    CHECK(run.out.find(" to 1 N/ms, held back 0; no trips\n") != std::string::npos);
    const auto rows = rows_of(contents(folder / "out.csv"));
    REQUIRE(rows.size() == 20000);

    // As the session asks: N per metre of terrain, from a row that the guard let pass.
    const Row& firmest = *std::ranges::max_element(rows, {}, [](const Row& row) {
        return row.guard == "none" ? distance(row.force, {0, 0, 0}) : 0;
    });
    const double per_metre = distance(firmest.force, {0, 0, 0}) / distance(firmest.proxy, firmest.stylus);
    // A rounding of a coordinate, as above, and of the time.
    const double tolerance = per_metre * (in_float ? 1e-2 : 1e-10) + 1e-9;
    std::array<double, 3> last{};
    std::map<std::string, int> acted;
    for (const Row& row : rows) {
        // By a ramp of half a second, no longer than the device can, and there as fast as the slew allows.
        const double asked = row.contact ? per_metre * distance(row.proxy, row.stylus) : 0;
        const double gain =
            std::min(1.0, row.t / 0.5) * std::min(1.0, device.max_force / std::max(asked, 1e-9));
        std::array<double, 3> target{}, sent{};
        for (std::size_t axis = 0; axis < 3 && row.contact; ++axis)
            target[axis] = gain * per_metre * (row.proxy[axis] - row.stylus[axis]);
        const double share = std::min(1.0, device.max_slew / std::max(distance(target, last), 1e-9));
        for (std::size_t axis = 0; axis < 3; ++axis) sent[axis] = std::lerp(last[axis], target[axis], share);
        if (distance(row.force, sent) > tolerance) FAIL("another force at t = " << row.t);
        if (row.guard == "none" && std::abs(distance(row.force, {0, 0, 0}) - asked) > tolerance)
            FAIL("something acted at t = " << row.t);
        last = row.force;
        ++acted[row.guard];
    }
    CHECK(acted["none"] > 10000);
    CHECK(acted["ramped"] > 0);
    if (hardness > 1) CHECK((acted["slewed"] > 100 && acted["clamped"] > 100));
    CHECK(acted["none"] + acted["ramped"] + acted["slewed"] + acted["clamped"] == 20000);
}

TEST_CASE("touch_terrain: says by name what tripped the guard, and when", "[touch_terrain]") {
    const Folder folder;
    folder.samples<float>("t.bil", {0, 0, 0, 0});
    folder.text("t.hdr", "NROWS 2\nNCOLS 2\nNBITS 32\nPIXELTYPE FLOAT\n");
    // Begins below the ground, or leaps over it in a millisecond; comes back each time.
    for (const auto& [trip, path] :
         {std::pair<std::string, std::string>{
              "buried", "0,0.2,0.5,-0.1\n1,0.8,0.5,-0.1\n2,0.8,0.5,0.2\n3,0.5,0.5,-0.05\n"},
          {"jump", "0,0.1,0.5,0.01\n1,0.1,0.5,-0.01\n1.001,0.7,0.5,-0.01\n3,0.7,0.5,-0.01\n"}}) {
        for (const std::string device : {"touch", "premium"}) {
            CAPTURE(trip, device);
            folder.text("p.csv", "t,x,y,z\n" + path);
            const Run run = folder.run("t.bil --path p.csv --record out.csv --device " + device);
            REQUIRE(run.code == 0);
            CHECK(run.out.find("; trips: " + trip + " 1 (see ") != std::string::npos);
            const auto rows = rows_of(contents(folder / "out.csv"));
            std::size_t tripped = 0;
            for (const Row& row : rows) {
                if (row.guard != trip) continue;
                ++tripped;
                CHECK(row.force == std::array<double, 3>{});
            }
            CHECK(tripped > 5);
            CHECK((run.out.find("\nburied ") != std::string::npos) == (trip == "buried"));
            CHECK(rows.back().contact);
            CHECK(rows.back().guard == "none");
            CHECK(distance(rows.back().force, {0, 0, 0}) > 0.1);
        }
    }
}

TEST_CASE("touch_terrain: behind a hole that it fell into the hand comes up and lands again",
          "[touch_terrain]") {
    // Level ground with a gap from x = 2 to 5, crossed below the surface.
    const Folder folder;
    folder.samples<float>("t.bil", {0, 0, 0, 9, 9, 0, 0, 0, 0, 0, 0, 9, 9, 0, 0, 0});
    folder.text("t.hdr", "NROWS 2\nNCOLS 8\nNBITS 32\nPIXELTYPE FLOAT\nNODATA 9\n");
    folder.text("p.csv", "t,x,y,z\n0,0.5,0.5,0.3\n1,0.8,0.5,-0.3\n4,6.5,0.5,-0.3\n");
    const std::string device = GENERATE("touch", "premium");
    CAPTURE(device);
    const Run run = folder.run("t.bil --path p.csv --record out.csv --device " + device);
    REQUIRE(run.code == 0);
    CHECK(run.out.find("; trips: buried 1 (see ") != std::string::npos);
    const auto rows = rows_of(contents(folder / "out.csv"));
    std::vector<std::string> went; // one status after the other
    std::size_t buried = 0;
    for (const Row& row : rows) {
        if (went.empty() || went.back() != row.status) went.push_back(row.status);
        buried += row.status == "buried";
    }
    std::string all;
    for (const std::string& status : went) all += status + ' ';
    CHECK(all == "free contact left_at_hole off_surface buried free contact ");
    CHECK(buried < 200); // 0.3 of 6 m is 17 of a Premium's 343 mm, at 0.1 m/s
}

TEST_CASE("touch_terrain: on a terrain full of holes the hand is never below the surface for long",
          "[touch_terrain][real]") {
    const auto file = hfh::test::shared_file_or_skip("swissalps_voids.bil");
    if (!file) return;
    const Folder folder;
    const std::string device = GENERATE("touch", "premium");
    CAPTURE(device);
    REQUIRE(folder.run("'" + *file + "' --record out.csv --device " + device).code == 0);
    std::size_t touching = 0, buried = 0, longest = 0;
    for (const Row& row : rows_of(contents(folder / "out.csv"))) {
        touching += row.contact;
        buried = row.status == "buried" ? buried + 1 : 0;
        longest = std::max(longest, buried);
    }
    CHECK(touching > 11000);
    CHECK(longest > 0);
    CHECK(longest < 100);
}

TEST_CASE("touch_terrain: over radar voids that are bridged the hand stays in contact",
          "[touch_terrain][real]") {
    const auto file = hfh::test::shared_file_or_skip("swissalps_voids.bil");
    if (!file) return;
    const Folder folder;
    REQUIRE(folder.run("'" + *file + "' --record out.csv --bridge 16").code == 0);
    std::size_t touching = 0, updates = 0;
    for (const Row& row : rows_of(contents(folder / "out.csv"))) {
        touching += row.contact;
        ++updates;
    }
    CHECK(touching > updates / 10 * 9);
}

TEST_CASE("touch_terrain: a device goes along any path that fits a scale, and refuses others",
          "[touch_terrain]") {
    const Folder folder;
    folder.samples<float>("t.bil", {0, 0, 0, 0});
    folder.text("t.hdr", "NROWS 2\nNCOLS 2\nNBITS 32\nPIXELTYPE FLOAT\n");
    const auto touch = [&](const std::string& rows) {
        folder.text("p.csv", "t,x,y,z\n" + rows);
        const Run run = folder.run("t.bil --device touch --path p.csv --record out.csv");
        CAPTURE(rows, run.err);
        if (run.code == 0) return rows_of(contents(folder / "out.csv"));
        CHECK(run.code == 2);
        CHECK(run.err.find("The path") != std::string::npos);
        return std::vector<Row>{};
    };
    // At 1 kHz, whatever the rows; at the end the device has come where the hand waits for it.
    const auto slow = touch("5,0.2,0.5,0.6\n7,0.8,0.5,0.6\n7.1,0.8,0.5,0.6\n");
    REQUIRE(slow.size() == 2101);
    CHECK(slow.front().t == 5);
    CHECK(slow.back().t == Approx(7.1));
    CHECK(slow.front().stylus[0] == Approx(0.2).margin(1e-3));
    CHECK(slow.back().stylus[0] == Approx(0.8).margin(0.01)); // friction: 0.87 mm of 144
    CHECK(touch("5,0.5,0.5,1\n").size() == 1);
    CHECK(touch("0,0.5,0.5,1\n0,0.6,0.5,1\n0,0.7,0.5,1\n").size() == 1);
    CHECK(touch("0,-1e30,0.5,1\n0.1,1e30,0.5,1\n").size() == 101);
    CHECK(touch("0,-1e308,0.5,1\n0.1,1e308,0.5,1\n").empty());
    CHECK(touch("0,0,0,1\n0.1,1e-320,0,1\n").empty());
    CHECK(touch("0,0,0,1\n1e9,1,0,1\n").empty());
    CHECK(touch("-1e308,0,0,1\n1e308,1,0,1\n").empty());
}

TEST_CASE("touch_terrain: a recorded path replayed gives the same record", "[touch_terrain]") {
    const Folder folder;
    REQUIRE(folder.run("--device none --record first.csv").code == 0);
    const std::string first = contents(folder / "first.csv");
    folder.text("path.csv", path_in(first));
    REQUIRE(folder.run("--path path.csv --record second.csv").code == 0);
    CHECK((contents(folder / "second.csv") == first));
}

TEST_CASE(
    "touch_terrain: a recorded path replayed gives the same record from a mapped file of the same heights",
    "[touch_terrain]") {
    const auto bil = hfh::test::shared_file_or_skip("spanish_peaks.bil");
    if (!bil) return;
    const Folder folder;
    REQUIRE(folder.run("--device none --record first.csv").code == 0);
    const std::string first = contents(folder / "first.csv");
    folder.text("path.csv", path_in(first));
    REQUIRE(folder.run("'" + *bil + "' --path path.csv --record second.csv").code == 0);
    CHECK((contents(folder / "second.csv") == first));
}

TEST_CASE("touch_terrain: north is up and y, whatever the file", "[touch_terrain]") {
    // One high sample in the north-west corner of 3 x 3, 10 m cells: at (0, 20).
    const Folder folder;
    folder.samples<std::uint8_t>("t.bil", {100, 0, 0, 0, 0, 0, 0, 0, 0});
    folder.text("t.hdr", "NROWS 3\nNCOLS 3\n");
    write_png(folder / "t.png", 3, 3, 8, PNG_COLOR_TYPE_GRAY, {100, 0, 0, 0, 0, 0, 0, 0, 0});
    folder.text("p.csv", "t,x,y,z\r\n0,1,19,200\r\n0,1,19,75\r\n"); // 81 m there
    for (const std::string file : {"t.bil", "t.png"}) {
        REQUIRE(folder.run(file + " --spacing 10 --path p.csv --record out.csv").code == 0);
        CHECK(rows_of(contents(folder / "out.csv")).back().contact);
        REQUIRE(folder.run(file + " --spacing 10 --height-scale 0.9 --path p.csv --record out.csv").code ==
                0);
        CHECK_FALSE(rows_of(contents(folder / "out.csv")).back().contact);
        REQUIRE(folder.run(file + " --spacing 10,20 --path p.csv --record out.csv").code == 0);
        CHECK_FALSE(rows_of(contents(folder / "out.csv")).back().contact);
    }
}

TEST_CASE("touch_terrain: prints its summary and keeps nothing beside the heights", "[touch_terrain]") {
    const Folder folder;
    const Run run = folder.run("");
    CHECK(run.code == 0);
    for (const char* const word :
         {"spanish_peaks.png, 300 x 300", "73.596 x 92.491 m", "20,000", "in contact", "patches", "median",
          "99.9 %", "worst", "largest force", "bytes kept beside the heights: 0"}) {
        CAPTURE(word);
        CHECK(run.out.find(word) != std::string::npos);
    }
    CHECK(folder.run("'" HFH_SOURCE_DIR "/examples/data/spanish_peaks.png'").out.find("73.596") !=
          std::string::npos);
    CHECK(run.out.find("--spacing") == std::string::npos);
    CHECK(run.out.find("buried") == std::string::npos);
    CHECK(folder.listing().empty());
    CHECK(folder.run("--help").code == 0);
    write_png(folder / "t.png", 2, 2, 8, PNG_COLOR_TYPE_GRAY, {0, 0, 0, 0});
    CHECK(folder.run("t.png").out.find("1 x 1 m, which the file does not say (see --spacing)\n") !=
          std::string::npos);
    CHECK(folder.run("t.png --spacing 1").out.find("1 x 1 m\n") != std::string::npos);
}

TEST_CASE("touch_terrain: draws a picture of the built-in stroke", "[touch_terrain]") {
    if (!hfh::test::has_program_or_skip("gnuplot")) return;
    const Folder folder;
    const Run run = folder.run("--picture \"it's a picture.png\"");
    CAPTURE(run.err);
    REQUIRE(run.code == 0);
    CHECK(folder.listing().size() == 1);
    png_image image{};
    image.version = PNG_IMAGE_VERSION;
    REQUIRE(png_image_begin_read_from_file(&image, (folder / "it's a picture.png").c_str()) != 0);
    CHECK(image.width == 1400);
    CHECK(image.height > 1000);
    png_image_free(&image);
}

TEST_CASE("touch_terrain: draws a picture of every odd path and terrain", "[touch_terrain]") {
    if (!hfh::test::has_program_or_skip("gnuplot")) return;
    const Folder folder;
    folder.samples<float>("t.bil", {0, 0, 0, 0});
    folder.text("t.hdr", "NROWS 2\nNCOLS 2\nNBITS 32\nPIXELTYPE FLOAT\nNODATA 7\n");
    folder.text("one.csv", "t,x,y,z\n5,0.5,0.5,1\n");
    folder.text("off.csv", "t,x,y,z\n0,-1e6,1e300,1\n1,1e300,-3,-1\n");
    for (const std::string arguments : {"", "--path one.csv", "--path off.csv", "--float --path off.csv",
                                        "--spacing 1e-9", "--spacing 1e9,1"}) {
        const Run run = folder.run("t.bil --picture out.png " + arguments);
        CAPTURE(arguments, run.err);
        CHECK(run.code == 0);
        CHECK(fs::file_size(folder / "out.png") > 1000);
    }
    folder.samples<float>("t.bil", {7, 7, 7, 7}); // nothing but holes
    CHECK(folder.run("t.bil --picture out.png").code == 0);
}
