#include "quantities.hpp"
#include "viewer.hpp"

#include <imgui.h>

#include <imgui_stdlib.h>

#include <limits>

namespace viewer {
namespace {

/// A slider of a double.
bool slide(const char* name, double& value, double low, double high, const char* format) {
    auto shown = static_cast<float>(value);
    const bool changed =
        ImGui::SliderFloat(name, &shown, static_cast<float>(low), static_cast<float>(high), format);
    if (changed) value = static_cast<double>(shown);
    return changed;
}

/// The same, of a value that is held in thousandths of what is shown.
bool slide_milli(const char* name, double& value, double low, double high, const char* format) {
    double shown = 1e3 * value;
    const bool changed = slide(name, shown, low, high, format);
    if (changed) value = 1e-3 * shown;
    return changed;
}

/// The ball that touches, as it is in the hand; in brackets as it is on the terrain.
void tip_slider(demo::Tip& tip, const HandState& hand, bool feet) {
    bool keeps_size = tip.on_terrain == 0;
    double radius = tip.radius(hand.scale) / hand.scale;
    const std::string shown = "%.2f mm (" + length_text(hand.tip, feet) + ")";
    const bool slid = slide_milli("tip", radius, 0, 10, shown.c_str());
    const bool changed = ImGui::Checkbox("tip keeps its size in the hand", &keeps_size);
    if (slid || changed) tip = keeps_size ? demo::Tip{0, radius} : demo::Tip{radius * hand.scale, 0};
}

void feel_sliders(Settings& settings, const HandState& hand) {
    Feel& feel = settings.feel;
    slide("stiffness", feel.stiffness, 50, 800, "%.0f N/m");
    slide("friction", feel.friction, 0, 1, "%.2f");
    slide("damping", feel.damping, 0, 3, "%.2f N s/m");
    ImGui::Checkbox("smooth force over cells (shading)", &feel.shading);
    tip_slider(feel.tip, hand, settings.feet);
    slide_milli("release", feel.release_speed, 0, 2,
                feel.release_speed > 0 ? "%.2f mm an update" : "at once");
    slide("press", settings.firmness, 0.2, 3, "%.1f N");
}

void level_sliders(LevelChoice& level, const HandState& hand, double coarsest) {
    ImGui::Checkbox("level by scale", &level.by_scale);
    if (level.by_scale) {
        slide_milli("cell in the hand", level.cell_at_hand, 0.1, 5, "%.2f mm");
        level.level = hand.level;
    } else {
        slide("level", level.level, 0, coarsest, "%.2f");
    }
}

void look_sliders(Settings& settings) {
    Look& look = settings.look;
    slide("height x", settings.exaggeration, 0.25, 4, "%.2f");
    slide("light from", look.light_azimuth, -3.14, 3.14, "%.2f rad");
    slide("light height", look.light_elevation, 0.1, 1.5, "%.2f rad");
    slide("relief", look.relief, 0, 3, "%.2f");
    if (ImGui::BeginCombo("tint", palettes[look.palette].name)) {
        for (std::size_t k = 0; k < palettes.size(); ++k)
            if (ImGui::Selectable(palettes[k].name, k == look.palette)) look.palette = k;
        ImGui::EndCombo();
    }
    ImGui::Checkbox("contours", &look.contours);
    ImGui::SameLine();
    ImGui::Checkbox("cells", &look.cells);
    ImGui::SameLine();
    ImGui::Checkbox("feet", &settings.feet);
}

void brush_controls(Brush& brush, const HandState& hand, PanelWishes& wishes, std::string& save_as) {
    int kind = static_cast<int>(brush.kind);
    ImGui::RadioButton("touch", &kind, 0);
    ImGui::SameLine();
    ImGui::RadioButton("dig", &kind, 1);
    ImGui::SameLine();
    ImGui::RadioButton("heap", &kind, 2);
    brush.kind = static_cast<BrushKind>(kind);
    slide_milli("brush radius", brush.radius, 1, 20, "%.1f mm");
    slide_milli("brush rate", brush.rate, 0.5, 20, "%.1f mm/s N");
    if (ImGui::Button("undo") && hand.undoable > 0) wishes.undo = true;
    ImGui::SameLine();
    ImGui::Text("%u strokes", hand.undoable);
    ImGui::InputText("##file", &save_as);
    ImGui::SameLine();
    if (ImGui::Button("save as")) wishes.save = true;
}

} // namespace

PanelWishes draw_panel(Settings& settings, const HandState& hand, double coarsest_level,
                       const glm::ivec2& size, float pixels) {
    PanelWishes wishes;
    ImGui::SetNextWindowPos({static_cast<float>(size.x) - 12 * pixels, 12 * pixels}, ImGuiCond_Appearing,
                            {1, 0});
    ImGui::SetNextWindowSize({panel_width * pixels, 0}, ImGuiCond_Appearing);
    ImGui::SetNextWindowSizeConstraints(
        {0, 0}, {std::numeric_limits<float>::max(), static_cast<float>(size.y) - 24 * pixels});
    // Of another scale it is another window for Dear ImGui, which gets its place and size anew.
    const std::string name = "Panel###" + std::to_string(pixels);
    if (ImGui::Begin(name.c_str(), &settings.shows_panel, ImGuiWindowFlags_NoFocusOnAppearing)) {
        ImGui::PushItemWidth(150 * pixels);
        if (ImGui::CollapsingHeader("Feel", ImGuiTreeNodeFlags_DefaultOpen)) feel_sliders(settings, hand);
        if (ImGui::CollapsingHeader("Level of detail", ImGuiTreeNodeFlags_DefaultOpen))
            level_sliders(settings.level, hand, coarsest_level);
        if (ImGui::CollapsingHeader("Brush", ImGuiTreeNodeFlags_DefaultOpen))
            brush_controls(settings.brush, hand, wishes, settings.save_as);
        if (ImGui::CollapsingHeader("Look")) look_sliders(settings);
        if (ImGui::Button("whole terrain")) wishes.home = true;
        ImGui::SameLine();
        if (ImGui::Button("keys")) settings.shows_keys = !settings.shows_keys;
        ImGui::PopItemWidth();
    }
    ImGui::End();
    return wishes;
}

} // namespace viewer
