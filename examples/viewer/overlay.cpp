#include "overlay.hpp"

#include "marker_drawer.hpp"
#include "quantities.hpp"

#include <imgui.h>

#include <backends/imgui_impl_opengl3.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <filesystem>
#include <vector>

namespace viewer {
namespace {

constexpr float margin = 12, font_size = 15;

/// Readable fonts that many systems have; without them Dear ImGui's own is taken, which has no scale.
ImFont* load_font(ImGuiIO& io, float size) {
    static constexpr std::array<ImWchar, 7> letters{0x20, 0xff, 0x2010, 0x2265, 0x370, 0x3ff, 0};
    for (const char* file :
         {"/usr/share/fonts/truetype/dejavu/DejaVuSans.ttf", "/usr/share/fonts/TTF/DejaVuSans.ttf",
          "/usr/share/fonts/truetype/liberation/LiberationSans-Regular.ttf",
          "/usr/share/fonts/truetype/noto/NotoSans-Regular.ttf"}) {
        std::error_code none;
        if (std::filesystem::exists(file, none))
            return io.Fonts->AddFontFromFileTTF(file, size, nullptr, letters.data());
    }
    ImFontConfig config;
    config.SizePixels = 13 * std::max(1.0f, std::round(size / 13));
    return io.Fonts->AddFontDefault(&config);
}

constexpr ImU32 ink = IM_COL32(255, 255, 255, 255), backing = IM_COL32(16, 20, 28, 190),
                dim = IM_COL32(200, 206, 214, 255);

ImU32 colour_of(const glm::vec3& c) { return ImGui::ColorConvertFloat4ToU32({c.x, c.y, c.z, 1}); }

/// A box of lines of text; gives its size.
class Board {
public:
    explicit Board(float pixels) : pixels_{pixels} {}
    void add(const std::string& name, const std::string& value) { rows_.push_back({name, value}); }
    /// Each value below its name, in lines that are no wider than `width`.
    void stack(float width) {
        std::vector<Row> lines;
        for (const Row& row : rows_) {
            lines.push_back({row.name, ""});
            const char *at = row.value.c_str(), *const end = at + row.value.size();
            while (at < end) {
                const char* const next = ImGui::GetFont()->CalcWordWrapPositionA(
                    ImGui::GetFontSize() / ImGui::GetFont()->FontSize, at, end, width - 26 * pixels_);
                lines.push_back({"", {at, std::max(next, at + 1)}});
                at = std::max(next, at + 1);
                while (at < end && *at == ' ') ++at;
            }
        }
        rows_ = std::move(lines);
        is_stacked_ = true;
    }

    [[nodiscard]] ImVec2 size() const {
        float names = 0, values = 0;
        for (const Row& row : rows_) {
            names = std::max(names, ImGui::CalcTextSize(row.name.c_str()).x);
            values = std::max(values, ImGui::CalcTextSize(row.value.c_str()).x);
        }
        const float gap = names > 0 && values > 0 ? 10 * pixels_ : 0;
        return {(is_stacked_ ? std::max(names, gap + values) : names + gap + values) + 16 * pixels_,
                static_cast<float>(rows_.size()) * ImGui::GetTextLineHeightWithSpacing() + 10 * pixels_};
    }
    void draw(const ImVec2& at) const {
        ImDrawList& list = *ImGui::GetBackgroundDrawList();
        const ImVec2 whole = size();
        list.AddRectFilled(at, {at.x + whole.x, at.y + whole.y}, backing, 5 * pixels_);
        float names = 0;
        for (const Row& row : rows_) names = std::max(names, ImGui::CalcTextSize(row.name.c_str()).x);
        const float indent = is_stacked_ ? 0 : names;
        float y = at.y + 6 * pixels_;
        for (const Row& row : rows_) {
            list.AddText({at.x + 8 * pixels_, y}, dim, row.name.c_str());
            const float x = names > 0 ? at.x + 18 * pixels_ + indent : at.x + 8 * pixels_;
            list.AddText({x, y}, ink, row.value.c_str());
            y += ImGui::GetTextLineHeightWithSpacing();
        }
    }

private:
    struct Row {
        std::string name, value;
    };
    std::vector<Row> rows_;
    float pixels_;
    bool is_stacked_ = false;
};

std::string fixed(double value, int decimals) {
    char digits[40];
    std::snprintf(digits, sizeof digits, "%.*f", decimals, value);
    return digits;
}

const char* in_words(const HandState& hand) {
    switch (hand.status) {
    case hfh::ContactStatus::contact:
    case hfh::ContactStatus::descent_limit: return "in contact";
    case hfh::ContactStatus::free:
    case hfh::ContactStatus::sweep_limit: return "above the ground";
    case hfh::ContactStatus::buried: return "below the ground: moving out";
    case hfh::ContactStatus::off_surface:
    case hfh::ContactStatus::left_at_hole:
    case hfh::ContactStatus::left_at_border: return hand.over_ground ? "above the ground" : "no ground here";
    case hfh::ContactStatus::bad_input: return "no position";
    }
    return "";
}

Board readouts(const OverlayText& text, float pixels) {
    const HandState& hand = text.hand;
    Board board{pixels};
    const double newtons = glm::length(hand.force);
    board.add("touch", in_words(hand));
    board.add("force", fixed(newtons, 2) + " N");
    const double deep = hand.touching() ? glm::length(hand.proxy - hand.stylus) : 0;
    board.add("depth", fixed(1e3 * deep / hand.scale, 1) + " mm of hand, " + length_text(deep, text.feet, 2));
    board.add("east, north",
              length_text(hand.proxy.x, text.feet, 5) + ", " + length_text(hand.proxy.y, text.feet, 5));
    board.add("height",
              hand.over_ground || hand.touching() ? length_text(hand.proxy.z, text.feet, 5) : "none");
    board.add("slope", fixed(text.slope * 57.29577951308232, 0) + "\u00b0");
    board.add("scale", "1 mm of hand = " + length_text(1e-3 * hand.scale, text.feet, 3));
    board.add("level", fixed(hand.level, 1) + (hand.wanted_level < hand.level ? ", waits for the disk" : ""));
    return board;
}

void draw_scale_bar(const OverlayText& text, const Camera& camera, const glm::ivec2& size, float pixels) {
    ImDrawList& list = *ImGui::GetBackgroundDrawList();
    const double metre_of_pixel = camera.pixel_size(size) * text.hand.scale;
    const double unit = text.feet ? 0.3048 : 1.0;
    const double length = unit * round_number(180 * static_cast<double>(pixels) * metre_of_pixel / unit);
    const auto bar = static_cast<float>(length / metre_of_pixel);
    const std::string ground = length_text(length, text.feet),
                      hand = demo::rounded(1e3 * length / text.hand.scale) + " mm of hand";
    const float line = ImGui::GetTextLineHeight();
    const float widest =
        std::max({bar, ImGui::CalcTextSize(ground.c_str()).x, ImGui::CalcTextSize(hand.c_str()).x});
    const ImVec2 at{margin * pixels, static_cast<float>(size.y) - margin * pixels - 2 * line - 26 * pixels};
    list.AddRectFilled(at, {at.x + widest + 20 * pixels, static_cast<float>(size.y) - margin * pixels},
                       backing, 5 * pixels);
    const float x = at.x + 10 * pixels, y = at.y + line + 12 * pixels;
    list.AddText({x, at.y + 4 * pixels}, ink, ground.c_str());
    list.AddRectFilled({x, y - 2 * pixels}, {x + bar, y + 2 * pixels}, ink);
    for (const float end : {x, x + bar - 2 * pixels})
        list.AddRectFilled({end, y - 6 * pixels}, {end + 2 * pixels, y + 6 * pixels}, ink);
    list.AddText({x, y + 8 * pixels}, dim, hand.c_str());
}

void draw_chart(const ForceHistory& force, const glm::ivec2& size, float pixels) {
    ImDrawList& list = *ImGui::GetBackgroundDrawList();
    const float line = ImGui::GetTextLineHeight();
    const float width = std::min(320 * pixels, 0.4f * static_cast<float>(size.x)), height = 96 * pixels;
    const ImVec2 high{static_cast<float>(size.x) - margin * pixels,
                      static_cast<float>(size.y) - margin * pixels};
    const ImVec2 low{high.x - width, high.y - height - 2 * line};
    list.AddRectFilled(low, high, backing, 5 * pixels);
    float most = 2;
    for (std::size_t k = 0; k < ForceHistory::columns; ++k) most = std::max(most, 1.1f * force[k].highest);
    const float left = low.x + 34 * pixels, right = high.x - 8 * pixels, bottom = high.y - line - 4 * pixels,
                top = low.y + line + 6 * pixels;
    const auto y_of = [&](float newtons) { return bottom - (bottom - top) * newtons / most; };
    list.AddText({left, low.y + 3 * pixels}, dim, "force, N");
    const double step = round_number(static_cast<double>(most) / 2);
    for (double newtons = 0; newtons <= static_cast<double>(most); newtons += step) {
        const float y = y_of(static_cast<float>(newtons));
        list.AddLine({left, y}, {right, y}, IM_COL32(255, 255, 255, 50), pixels);
        const std::string label = demo::rounded(newtons);
        list.AddText({left - 6 * pixels - ImGui::CalcTextSize(label.c_str()).x, y - line / 2}, dim,
                     label.c_str());
    }
    for (int s = -6; s <= 0; s += 2) {
        const float x = right + (right - left) * static_cast<float>(s / ForceHistory::seconds);
        list.AddLine({x, top}, {x, bottom}, IM_COL32(255, 255, 255, 35), pixels);
        const std::string label = s == 0 ? "now" : std::to_string(s) + " s";
        const float wide = ImGui::CalcTextSize(label.c_str()).x;
        list.AddText({std::min(x - wide / 2, right - wide), bottom + 2 * pixels}, dim, label.c_str());
    }
    const float step_x = (right - left) / static_cast<float>(ForceHistory::columns);
    ImVec2 last{};
    for (std::size_t k = 0; k < ForceHistory::columns; ++k) {
        const ForceHistory::Column& column = force[k];
        const float x = left + step_x * static_cast<float>(k);
        const ImVec2 point{x, y_of(column.highest)};
        if (column.contact)
            list.AddRectFilled({x, y_of(column.highest)}, {x + step_x, bottom}, IM_COL32(214, 94, 0, 90));
        if (k > 0) list.AddLine(last, point, IM_COL32(255, 176, 84, 255), 1.5f * pixels);
        last = point;
    }
}

void draw_height_legend(const OverlayText& text, const glm::ivec2& size, float pixels) {
    ImDrawList& list = *ImGui::GetBackgroundDrawList();
    const float line = ImGui::GetTextLineHeight();
    const std::string high = length_text(text.highest, text.feet, 4),
                      low = length_text(text.lowest, text.feet, 4, text.highest);
    const std::string interval =
        text.contour_interval > 0 ? "contours every " + length_text(text.contour_interval, text.feet) : "";
    const float bar = 130 * pixels;
    const float lows = ImGui::CalcTextSize(low.c_str()).x, highs = ImGui::CalcTextSize(high.c_str()).x;
    const float width =
        std::max(bar + lows + highs + 16 * pixels, ImGui::CalcTextSize(interval.c_str()).x) + 16 * pixels;
    const float height = (interval.empty() ? 1 : 2) * ImGui::GetTextLineHeightWithSpacing() + 10 * pixels;
    const ImVec2 at{margin * pixels,
                    static_cast<float>(size.y) - 2 * margin * pixels - 2 * line - 26 * pixels - height};
    list.AddRectFilled(at, {at.x + width, at.y + height}, backing, 5 * pixels);
    const float x = at.x + 8 * pixels + lows + 8 * pixels, y = at.y + 6 * pixels;
    list.AddText({at.x + 8 * pixels, y}, ink, low.c_str());
    constexpr int steps = 26;
    for (int k = 0; k < steps; ++k) {
        const float from = x + bar * static_cast<float>(k) / steps;
        list.AddRectFilled({from, y + 2 * pixels}, {from + bar / steps + 1, y + line},
                           colour_of(palettes[text.palette].at((static_cast<float>(k) + 0.5f) / steps)));
    }
    list.AddText({x + bar + 8 * pixels, y}, ink, high.c_str());
    if (!interval.empty())
        list.AddText({at.x + 8 * pixels, y + ImGui::GetTextLineHeightWithSpacing()}, dim, interval.c_str());
}

void draw_centred(const std::vector<std::string>& lines, float y, const glm::ivec2& size, float pixels) {
    Board board{pixels};
    for (const std::string& text : lines) board.add("", text);
    const ImVec2 whole = board.size();
    board.draw({(static_cast<float>(size.x) - whole.x) / 2, y - whole.y / 2});
}

Board keys(float pixels) {
    Board board{pixels};
    board.add("move", "the hand follows the pointer over the ground");
    board.add("left button, Space", "press down: more firmly the longer it is held");
    board.add("wheel, + and -", "zoom about what is touched");
    board.add("right button drag, Q E R F", "turn and tilt the view");
    board.add("Shift + right drag, arrows", "move the terrain under the hand");
    board.add("1, 2, 3", "touch, dig, heap");
    board.add("U, Ctrl+Z", "undo the last stroke");
    board.add("Home", "back to the whole terrain");
    board.add("Tab, H, Esc", "panel, this list, end");
    return board;
}

/// In the middle of what the panel leaves of the picture. In a narrow one it is as high as the picture and stands alone.
void draw_keys(const OverlayText& text, const glm::ivec2& size, float pixels, bool& stands_alone) {
    Board board = keys(pixels);
    const float panel = text.shows_panel ? (panel_width + margin) * pixels : 0;
    const float room = static_cast<float>(size.x) - panel - 2 * margin * pixels;
    stands_alone = board.size().x > room;
    if (stands_alone) board.stack(room);
    const ImVec2 whole = board.size();
    board.draw(
        {margin * pixels + std::max(room - whole.x, 0.0f) / 2, (static_cast<float>(size.y) - whole.y) / 2});
}

} // namespace

ImGuiLayer::ImGuiLayer(float pixels) : context_{ImGui::CreateContext()}, pixels_{pixels} {
    ImGuiIO& io = ImGui::GetIO();
    io.IniFilename = nullptr;
    io.LogFilename = nullptr;
    set_sizes();
    ImGui_ImplOpenGL3_Init("#version 330 core");
}

void ImGuiLayer::set_pixels(float pixels) {
    if (pixels == pixels_) return;
    pixels_ = pixels;
    ImGui::GetIO().Fonts->Clear();
    set_sizes();
    ImGui_ImplOpenGL3_DestroyFontsTexture();
    ImGui_ImplOpenGL3_CreateFontsTexture();
}

void ImGuiLayer::set_sizes() {
    load_font(ImGui::GetIO(), std::round(font_size * pixels_));
    ImGuiStyle style;
    ImGui::StyleColorsDark(&style);
    style.WindowRounding = 5;
    style.Colors[ImGuiCol_WindowBg].w = 0.86f;
    style.ScaleAllSizes(pixels_);
    ImGui::GetStyle() = style;
}

ImGuiLayer::~ImGuiLayer() {
    ImGui_ImplOpenGL3_Shutdown();
    ImGui::DestroyContext(context_);
}

void ImGuiLayer::begin_without_window(const glm::ivec2& size, float seconds) {
    ImGuiIO& io = ImGui::GetIO();
    io.DisplaySize = {static_cast<float>(size.x), static_cast<float>(size.y)};
    io.DeltaTime = std::max(seconds, 1e-4f);
    begin();
}

void ImGuiLayer::begin() {
    ImGui_ImplOpenGL3_NewFrame();
    ImGui::NewFrame();
}

void ImGuiLayer::draw() {
    ImGui::Render();
    ImGui_ImplOpenGL3_RenderDrawData(ImGui::GetDrawData());
}

void draw_overlay(const OverlayText& text, const ForceHistory& force, const Camera& camera,
                  const glm::ivec2& size, float pixels) {
    bool stands_alone = false;
    if (text.shows_keys) draw_keys(text, size, pixels, stands_alone);
    if (stands_alone) return;
    if (!text.shows_keys) readouts(text, pixels).draw({margin * pixels, margin * pixels});
    draw_height_legend(text, size, pixels);
    draw_scale_bar(text, camera, size, pixels);
    draw_chart(force, size, pixels);
    const float line = ImGui::GetTextLineHeightWithSpacing();
    ImDrawList& list = *ImGui::GetBackgroundDrawList();
    std::string machine = text.renderer;
    if (text.frames_per_second > 0) machine += " \u00b7 " + fixed(text.frames_per_second, 0) + " frames/s";
    machine += " \u00b7 update of the hand " + fixed(text.hand.microseconds, 0) + " \u00b5s";
    if (!text.real_time) machine += " \u00b7 no real-time priority";
    const float wide = ImGui::CalcTextSize(machine.c_str()).x;
    const ImVec2 at{(static_cast<float>(size.x) - wide) / 2,
                    static_cast<float>(size.y) - margin * pixels - line / 2};
    const float chart_left = static_cast<float>(size.x) -
                             std::min(320 * pixels, 0.4f * static_cast<float>(size.x)) - 2 * margin * pixels;
    if (at.x + wide < chart_left && at.x > 240 * pixels) {
        list.AddRectFilled({at.x - 6 * pixels, at.y - 2 * pixels}, {at.x + wide + 6 * pixels, at.y + line},
                           backing, 4 * pixels);
        list.AddText(at, dim, machine.c_str());
    }
    if (!text.shows_keys && text.shows_hint) {
        draw_centred(
            {text.in_a_hand
                 ? "Bring the stylus down to the ground. Its first button moves the hand without it."
                 : "Move the pointer over the ground and hold the left button (or Space) to press down.",
             "The wheel zooms about what you touch. H lists the keys."},
            0.8f * static_cast<float>(size.y) - 2 * line, size, pixels);
    }
    if (!text.message.empty()) draw_centred({text.message}, margin * pixels + 1.2f * line, size, pixels);
}

} // namespace viewer
