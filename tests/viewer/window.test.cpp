#include "catch.hpp"

#include "program.hpp"
#include "x_client.hpp"

#include <glm/ext/vector_double2.hpp>
#include <glm/ext/vector_double3.hpp>
#include <glm/geometric.hpp>

#include <chrono>
#include <cmath>
#include <optional>
#include <sstream>
#include <thread>
#include <vector>

// The program in a window of a real display, to which another client does what a person and a window manager would.

using namespace viewer_tests;

namespace {

constexpr unsigned left_button = 1;

void pass(int milliseconds) { std::this_thread::sleep_for(std::chrono::milliseconds{milliseconds}); }

/// A row of the record.
struct Row {
    double t = 0;
    bool touches = false;
    glm::dvec2 stylus{0.0};
    double newtons = 0;
};

std::vector<Row> rows_of(const std::filesystem::path& file) {
    std::ifstream in{file};
    std::vector<Row> rows;
    std::string line;
    std::getline(in, line);
    while (std::getline(in, line)) {
        std::istringstream fields{line};
        std::vector<double> values;
        for (std::string field; std::getline(fields, field, ',') && values.size() < 14;)
            values.push_back(field.empty() ? 0 : std::stod(field));
        if (values.size() < 14) continue;
        rows.push_back({values[0],
                        values[4] == 1,
                        {values[1], values[2]},
                        glm::length(glm::dvec3{values[11], values[12], values[13]})});
    }
    return rows;
}

/// How often it was touched. A pause of less than a fifth of a second does not count.
int touches_in(const std::vector<Row>& rows) {
    int touches = 0;
    double last = -1;
    for (const Row& row : rows) {
        if (!row.touches) continue;
        touches += row.t - last > 0.2;
        last = row.t;
    }
    return touches;
}

/// The viewer in a window. Ended, by force if need be, with this.
class Session {
public:
    explicit Session(const std::string& arguments, int dots_per_inch = 96,
                     const std::string& program = HFH_VIEWER)
        : display{"1000x800x24"}, client{display.name} {
        if (display.name.empty() || !client.is_connected()) return;
        client.set_dots_per_inch(dots_per_inch);
        const std::string command = "cd '" + folder.root.string() +
                                    "' && env -u WAYLAND_DISPLAY DISPLAY=" + display.name + " '" + program +
                                    "' --record a.csv " + arguments + " >out.txt 2>err.txt </dev/null";
        child_ = ::fork();
        if (child_ == 0) {
            ::setpgid(0, 0);
            ::execlp("sh", "sh", "-c", command.c_str(), static_cast<char*>(nullptr));
            ::_exit(127);
        }
        is_there = client.find_window();
    }
    ~Session() {
        if (child_ <= 0) return;
        ::kill(-child_, SIGKILL);
        ::waitpid(child_, nullptr, 0);
    }
    Session(const Session&) = delete;
    Session& operator=(const Session&) = delete;

    /// Waits for the end, for some seconds; the exit status, or -1.
    int end() {
        for (int k = 0; k < 200; ++k) {
            int status = 0;
            if (::waitpid(child_, &status, WNOHANG) == child_) {
                child_ = -1;
                return WIFEXITED(status) ? WEXITSTATUS(status) : -1;
            }
            pass(50);
        }
        return -1;
    }
    [[nodiscard]] std::string text(const char* file) const { return contents(folder.root / file); }
    [[nodiscard]] std::vector<Row> rows() const { return rows_of(folder.root / "a.csv"); }

    Folder folder;
    Display display;
    XClient client;
    bool is_there = false;

private:
    pid_t child_ = -1;
};

/// Whether all of the window has been drawn into: nothing that the viewer draws is quite black.
bool is_all_drawn(const XClient& client) {
    const auto pixels = client.picture();
    const glm::ivec2 size = client.size();
    return pixels.size() == static_cast<std::size_t>(size.x) * static_cast<std::size_t>(size.y) &&
           std::ranges::none_of(pixels, [](const auto& rgb) { return rgb[0] + rgb[1] + rgb[2] == 0; });
}

/// Waits for some seconds for that.
bool gets_all_drawn(const XClient& client) {
    for (int k = 0; k < 60 && !is_all_drawn(client); ++k) pass(50);
    return is_all_drawn(client);
}

bool is_ready(const Session& session) {
    if (session.display.name.empty()) {
        hfh::test::skip("Xvfb does not start here");
        return false;
    }
    INFO(session.text("err.txt"));
    REQUIRE(session.is_there);
    return true;
}

} // namespace

TEST_CASE("losing the focus or being minimised in mid-press lets go, and closing in mid-press ends well",
          "[window]") {
    if (!hfh::test::has_program_or_skip("Xvfb")) return;
    Session session{"--size 400x300"};
    if (!is_ready(session)) return;
    XClient& client = session.client;
    client.focus();
    client.move_pointer({200, 150});
    pass(300);
    client.press_button(left_button);
    pass(600);
    client.unfocus();
    pass(500);
    client.focus(); // the button is still down, but that press is over
    pass(300);
    client.release_button(left_button);
    pass(100);
    client.press_button(left_button);
    pass(600);
    client.minimise();
    pass(500);
    client.restore();
    pass(200);
    client.focus();
    client.release_button(left_button);
    pass(100);
    client.press_button(left_button);
    pass(600);
    client.close();
    CHECK(session.end() == 0);
    CHECK(session.text("err.txt").empty());
    CHECK(session.text("out.txt").find("haptic ticks") != std::string::npos);
    CHECK(session.text("out.txt").find("guard trips     none") != std::string::npos);

    const std::vector<Row> rows = session.rows();
    REQUIRE(rows.size() > 1000);
    std::string changes;
    for (std::size_t k = 1; k < rows.size(); ++k)
        if (rows[k].touches != rows[k - 1].touches) changes += std::to_string(rows[k].t) + " ";
    INFO("touch begins and ends at " << changes);
    CHECK(touches_in(rows) == 3);
    CHECK(rows.back().touches);
    CHECK(rows.back().newtons > 0.3);
}

TEST_CASE("a window that is resized is drawn whole, and the pointer points", "[window]") {
    if (!hfh::test::has_program_or_skip("Xvfb")) return;
    Session session{"--size 400x300"};
    if (!is_ready(session)) return;
    XClient& client = session.client;
    client.focus();
    for (const glm::ivec2& size : {glm::ivec2{900, 700}, {220, 160}, {640, 360}}) {
        client.resize(size);
        pass(200);
        CHECK(client.size() == size);
        CHECK(gets_all_drawn(client));
    }
    client.move_pointer({500, 100});
    pass(400);
    client.move_pointer({320, 180});
    pass(800);
    client.close();
    CHECK(session.end() == 0);
    // The middle of the picture is the middle of the terrain, 300 cells of 73.6 m and 92.5 m.
    const std::vector<Row> rows = session.rows();
    REQUIRE(!rows.empty());
    CHECK(std::abs(rows.back().stylus.x - 11040) < 400);
    CHECK(std::abs(rows.back().stylus.y - 13870) < 400);
}

TEST_CASE("on a screen of scale 2 the window and its text are twice as large", "[window]") {
    if (!hfh::test::has_program_or_skip("Xvfb")) return;
    Session session{"--size 400x300", 192};
    if (!is_ready(session)) return;
    XClient& client = session.client;
    CHECK(client.size() == glm::ivec2{800, 600});
    CHECK(gets_all_drawn(client));
    client.focus();
    client.move_pointer({400, 300});
    pass(800);
    // The first line of text is in a dark box, 12 pixels from the corner of an ordinary screen.
    const auto pixels = client.picture();
    REQUIRE(pixels.size() == 800 * 600);
    const auto brightness = [&](std::size_t x, std::size_t y) {
        const auto& rgb = pixels[800 * y + x];
        return rgb[0] + rgb[1] + rgb[2];
    };
    CHECK(brightness(18, 40) > 300);
    CHECK(brightness(30, 40) < 250);
    client.close();
    CHECK(session.end() == 0);
    const std::vector<Row> rows = session.rows();
    REQUIRE(!rows.empty());
    CHECK(std::abs(rows.back().stylus.x - 11040) < 400);
    CHECK(std::abs(rows.back().stylus.y - 13870) < 400);
}

TEST_CASE("a Phantom is held in place of the mouse", "[window]") {
    if (!hfh::test::has_program_or_skip("Xvfb")) return;
    // The hand of the fake comes down into the ground and up again within a second.
    Session session{"--device phantom --size 400x300", 96, HFH_VIEWER_WITH_FAKE};
    if (!is_ready(session)) return;
    pass(2500);
    session.client.close();
    CHECK(session.end() == 0);
    const std::string out = session.text("out.txt");
    INFO(out);
    CHECK(out.find("phantom         stopped; ") != std::string::npos);
    CHECK(out.find("left at 0.00 N") != std::string::npos);
    CHECK(out.find("breach") == std::string::npos);
    const std::vector<Row> rows = session.rows();
    REQUIRE(rows.size() > 1500);
    CHECK(touches_in(rows) >= 2);
    const auto firmest = std::ranges::max_element(rows, {}, &Row::newtons);
    CHECK(firmest->newtons > 2);
    CHECK(firmest->newtons < 3.4); // as much as that device gives
}

TEST_CASE("a Phantom whose connection breaks comes back", "[window]") {
    if (!hfh::test::has_program_or_skip("Xvfb")) return;
    ::setenv("HFH_TEST_EVENT", "LOSE", 1);
    Session session{"--device phantom --size 400x300", 96, HFH_VIEWER_WITH_FAKE};
    ::unsetenv("HFH_TEST_EVENT");
    if (!is_ready(session)) return;
    pass(4000); // it is tried again after half a second, does not start for a second, and then does
    session.client.close();
    CHECK(session.end() == 0);
    const std::string out = session.text("out.txt");
    INFO(out);
    CHECK(out.find("phantom         stopped; ") != std::string::npos);
    const std::vector<Row> rows = session.rows();
    CHECK(rows.size() > 1000);
    CHECK(touches_in(rows) >= 2);
}
