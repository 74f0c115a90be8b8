#include "catch.hpp"

#include "support/skip.hpp"

#include <algorithm>
#include <array>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <string>

#include <csignal>
#include <fcntl.h>
#include <sys/wait.h>
#include <unistd.h>

// The program itself, without a display and on one of its own.

namespace {

namespace fs = std::filesystem;

std::string contents(const fs::path& file) {
    std::ifstream in{file, std::ios::binary};
    return {std::istreambuf_iterator<char>{in}, {}};
}

/// A folder of its own, gone afterwards.
class Folder {
public:
    Folder() {
        std::string name = (fs::temp_directory_path() / "hfh-viewer-XXXXXX").string();
        REQUIRE(::mkdtemp(name.data()) != nullptr);
        root = name;
    }
    ~Folder() {
        std::error_code none;
        fs::remove_all(root, none);
    }
    Folder(const Folder&) = delete;
    Folder& operator=(const Folder&) = delete;
    fs::path root;
};

struct Run {
    int code = -1;
    std::string out, err;
};

/// `before`: stands in front of the command, as for a shell.
Run run(const Folder& folder, const std::string& arguments, const std::string& before = "") {
    const fs::path out = folder.root / "out.txt", err = folder.root / "err.txt";
    const std::string command = "cd '" + folder.root.string() + "' && " + before + " '" HFH_VIEWER "' " +
                                arguments + " >'" + out.string() + "' 2>'" + err.string() + "' </dev/null";
    const int status = std::system(command.c_str());
    return {WIFEXITED(status) ? WEXITSTATUS(status) : -1, contents(out), contents(err)};
}

bool is_one_sentence(const std::string& text) {
    return std::ranges::count(text, '\n') == 1 && text.ends_with(".\n") && text.starts_with("hfh_viewer: ");
}

bool can_draw(const Run& made) {
    if (made.code == 0) return true;
    hfh::test::skip(made.err.substr(0, made.err.find('\n')));
    return false;
}

/// A display that nobody looks at, ended with this.
class Display {
public:
    Display() {
        std::array<int, 2> told{};
        if (::pipe(told.data()) != 0) return;
        child_ = ::fork();
        if (child_ == 0) {
            const int nowhere = ::open("/dev/null", O_WRONLY);
            ::dup2(nowhere, 2);
            ::close(told[0]);
            const std::string number = std::to_string(told[1]);
            ::execlp("Xvfb", "Xvfb", "-displayfd", number.c_str(), "-screen", "0", "800x600x24", "-nolisten",
                     "tcp", static_cast<char*>(nullptr));
            ::_exit(127);
        }
        ::close(told[1]);
        std::string number;
        for (char c = 0; ::read(told[0], &c, 1) == 1 && c != '\n';) number += c;
        ::close(told[0]);
        if (!number.empty()) name = ":" + number;
    }
    ~Display() {
        if (child_ <= 0) return;
        ::kill(child_, SIGTERM);
        ::waitpid(child_, nullptr, 0);
    }
    Display(const Display&) = delete;
    Display& operator=(const Display&) = delete;
    std::string name;

private:
    pid_t child_ = -1;
};

} // namespace

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
         {"--size 12", "--size 10x10", "--frames 0", "--device joystick", "missing.bil",
          "--screenshot a.png --record a.png", "--path missing.csv --screenshot a.png"}) {
        const Run made = run(folder, arguments);
        INFO(arguments << ": " << made.err);
        CHECK(made.code == 2);
        CHECK(is_one_sentence(made.err));
    }
    CHECK(run(folder, "--help").code == 0);
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
