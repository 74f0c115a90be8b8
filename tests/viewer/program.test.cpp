#include "catch.hpp"

#include "program.hpp"

// The program itself, without a display and on one of its own.

using namespace viewer_tests;

TEST_CASE("without a display the viewer says so in one sentence", "[program]") {
    const Folder folder;
    const Run made = run(folder, "--frames 1", "env -u DISPLAY -u WAYLAND_DISPLAY");
    CHECK(made.code == 2);
    INFO(made.err);
    CHECK(is_one_sentence(made.err));
}

TEST_CASE("the viewer refuses what it cannot do in one sentence", "[program]") {
    const Folder folder;
    for (const char* arguments :
         {"--size 12", "--size 10x10", "--frames 0", "--device joystick", "missing.bil", "--tip -1",
          "--tip-hand nan", "--release 0", "--tip 20 --tip-hand 2", "--screenshot a.png --record a.png",
          "--path missing.csv --screenshot a.png"}) {
        const Run made = run(folder, arguments);
        INFO(arguments << ": " << made.err);
        CHECK(made.code == 2);
        CHECK(is_one_sentence(made.err));
    }
    CHECK(run(folder, "--help").code == 0);
}

TEST_CASE("a Phantom is refused in one sentence where it cannot be", "[program]") {
    const Folder folder;
    for (const char* arguments : {"--device phantom --screenshot a.png", "--device phantom --path a.csv",
#ifndef HFH_VIEWER_HAS_PHANTOM
                                  "--device phantom"
#endif
         }) {
        const Run made = run(folder, arguments);
        INFO(arguments << ": " << made.err);
        CHECK(made.code == 2);
        CHECK(is_one_sentence(made.err));
    }
}

TEST_CASE("an old context is refused in one sentence", "[program]") {
    const Folder folder;
    // Mesa pretends to be as old as it is told to be.
    const Run made = run(folder, "--frames 1 --screenshot a.png", "env MESA_GL_VERSION_OVERRIDE=2.1");
    INFO(made.err);
    if (made.code == 0) return hfh::test::skip("this driver does not pretend to be old");
    CHECK(made.code == 2);
    CHECK(is_one_sentence(made.err));
}

TEST_CASE("a screenshot and a record are the same every time", "[program]") {
    const Folder folder;
    const Run made = run(folder, "--frames 12 --size 320x200 --screenshot a.png --record a.csv");
    if (!can_draw(made)) return;
    REQUIRE(run(folder, "--frames 12 --size 320x200 --screenshot b.png --record b.csv").code == 0);
    const std::string record = contents(folder.root / "a.csv");
    CHECK(record == contents(folder.root / "b.csv"));
    CHECK(std::ranges::count(record, '\n') > 300);
    CHECK(contents(folder.root / "a.png").starts_with("\x89PNG"));
}

TEST_CASE("a hand that goes along a path is where the path says, with no device", "[program]") {
    const Folder folder;
    std::ofstream{folder.root / "path.csv"}
        << "t,x,y,z\n0,5000,9000,4000\n0.2,6000,9000,2500\n0.4,8000,9500,2500\n";
    const Run made = run(
        folder, "--frames 8 --size 320x200 --device none --path path.csv --screenshot a.png --record a.csv");
    if (!can_draw(made)) return;
    std::ifstream rows{folder.root / "a.csv"};
    std::string line;
    for (int k = 0; k < 102; ++k) std::getline(rows, line); // the update at 0.1 s
    CHECK(line.find(",5500,9000,3250,") != std::string::npos);
}

TEST_CASE("the window runs on a display, touches nothing by itself and ends in order", "[program]") {
    if (!hfh::test::has_program_or_skip("Xvfb")) return;
    const Display display;
    if (display.name.empty()) return hfh::test::skip("Xvfb does not start here");
    const Folder folder;
    const Run made = run(folder, "--frames 40 --size 400x300 --record a.csv",
                         "env -u WAYLAND_DISPLAY DISPLAY=" + display.name);
    INFO(made.err);
    CHECK(made.code == 0);
    CHECK(made.out.find("haptic ticks") != std::string::npos);
    CHECK(made.out.find("lateness (us)") != std::string::npos);
    CHECK(made.out.find("guard trips     none") != std::string::npos);
    CHECK(std::ranges::count(contents(folder.root / "a.csv"), '\n') > 10);
}
