#ifndef HFH_TESTS_VIEWER_PROGRAM_HPP
#define HFH_TESTS_VIEWER_PROGRAM_HPP

#include "support/skip.hpp"

#include <algorithm>
#include <array>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <string>

#include <csignal>
#include <fcntl.h>
#include <sys/wait.h>
#include <unistd.h>

// Calls the program itself, and gives it a display.

namespace viewer_tests {

namespace fs = std::filesystem;

inline std::string contents(const fs::path& file) {
    std::ifstream in{file, std::ios::binary};
    return {std::istreambuf_iterator<char>{in}, {}};
}

/// A folder of its own, gone afterwards.
class Folder {
public:
    Folder() {
        std::string name = (fs::temp_directory_path() / "hfh-viewer-XXXXXX").string();
        if (::mkdtemp(name.data()) == nullptr) std::abort();
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
inline Run run(const Folder& folder, const std::string& arguments, const std::string& before = "") {
    const fs::path out = folder.root / "out.txt", err = folder.root / "err.txt";
    const std::string command = "cd '" + folder.root.string() + "' && " + before + " '" HFH_VIEWER "' " +
                                arguments + " >'" + out.string() + "' 2>'" + err.string() + "' </dev/null";
    const int status = std::system(command.c_str());
    return {WIFEXITED(status) ? WEXITSTATUS(status) : -1, contents(out), contents(err)};
}

inline bool is_one_sentence(const std::string& text) {
    return std::ranges::count(text, '\n') == 1 && text.ends_with(".\n") && text.starts_with("hfh_viewer: ");
}

inline bool can_draw(const Run& made) {
    if (made.code == 0) return true;
    hfh::test::skip(made.err.substr(0, made.err.find('\n')));
    return false;
}

/// A display that nobody looks at, ended with this.
class Display {
public:
    explicit Display(const char* screen = "800x600x24") {
        std::array<int, 2> told{};
        if (::pipe(told.data()) != 0) return;
        child_ = ::fork();
        if (child_ == 0) {
            const int nowhere = ::open("/dev/null", O_WRONLY);
            ::dup2(nowhere, 2);
            ::close(told[0]);
            const std::string number = std::to_string(told[1]);
            ::execlp("Xvfb", "Xvfb", "-displayfd", number.c_str(), "-screen", "0", screen, "-nolisten", "tcp",
                     static_cast<char*>(nullptr));
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

} // namespace viewer_tests

#endif // HFH_TESTS_VIEWER_PROGRAM_HPP
