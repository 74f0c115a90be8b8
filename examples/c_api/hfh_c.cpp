#include "hfh_c.h"

#include <hfh/hfh.hpp>

#include <hfh/loop/any_haptic_loop.hpp>
#include <hfh/loop/ball_tip.hpp>
#include <hfh/terrain/min_max_pyramid.hpp>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <cstddef>
#include <cstring>
#include <limits>
#include <memory>
#include <new>
#include <type_traits>
#include <utility>

// Compiled without exceptions: all that is allocated is asked for with std::nothrow, and the library itself throws nothing.

namespace {

/// A struct of the caller's as this library knows it: members behind the end of a shorter one are zero. Empty where the size
/// is none, or a member is set behind the end of what is known here.
template <class Struct>
[[nodiscard]] bool read(const Struct* from, Struct& to) noexcept {
    to = {};
    if (!from || from->size < sizeof(std::uint32_t) * 2) return false;
    const auto* const bytes = reinterpret_cast<const unsigned char*>(from);
    for (std::size_t k = sizeof(Struct); k < from->size; ++k)
        if (bytes[k] != 0) return false;
    std::memcpy(&to, from, std::min<std::size_t>(from->size, sizeof(Struct)));
    return true;
}

[[nodiscard]] glm::dvec3 from_axes(std::int32_t axes, const double* p) noexcept {
    return axes == HFH_Y_UP_LEFT    ? glm::dvec3{p[0], p[2], p[1]}
           : axes == HFH_Y_UP_RIGHT ? glm::dvec3{p[0], -p[2], p[1]}
                                    : glm::dvec3{p[0], p[1], p[2]};
}
void to_axes(std::int32_t axes, const glm::dvec3& p, double (&to)[3]) noexcept {
    const glm::dvec3 turned = axes == HFH_Y_UP_LEFT    ? glm::dvec3{p.x, p.z, p.y}
                              : axes == HFH_Y_UP_RIGHT ? glm::dvec3{p.x, p.z, -p.y}
                                                       : p;
    for (int k = 0; k < 3; ++k) to[k] = turned[k];
}

template <hfh::Sample S>
struct NoData {
    S value{};
    bool is_told = false;
    [[nodiscard]] constexpr bool operator()(S sample) const noexcept { return is_told && sample == value; }
};

/// The hole's value as a sample, if it can be one.
template <hfh::Sample S>
[[nodiscard]] bool read(const hfh_field_options& options, NoData<S>& to) noexcept {
    if (options.has_no_data == 0) return true;
    const double value = options.no_data;
    if constexpr (std::is_integral_v<S>) {
        const bool fits = value >= static_cast<double>(std::numeric_limits<S>::lowest()) &&
                          value <= static_cast<double>(std::numeric_limits<S>::max());
        if (!fits || std::floor(value) != value) return false;
    }
    to = {static_cast<S>(value), true};
    return true;
}

[[nodiscard]] bool is_radius(double radius) noexcept {
    return hfh::is_at_least_zero(radius) && hfh::is_height(radius);
}

[[nodiscard]] bool is_release_speed(double speed) noexcept {
    return hfh::is_at_least_zero(speed) && hfh::is_finite(speed);
}

/// Of a loop, where the largest number is that a proxy does not glide.
[[nodiscard]] double loop_release_speed(double speed) noexcept {
    return speed > 0 ? speed : std::numeric_limits<double>::max();
}

[[nodiscard]] hfh::Material material_of(const hfh_material& m) noexcept {
    return {m.stiffness, m.static_friction, m.dynamic_friction, m.damping, m.shading != 0};
}

} // namespace

struct hfh_stylus {
    hfh_stylus(hfh_field* on, std::int32_t turned) noexcept : field{on}, axes{turned} {}
    hfh_stylus(const hfh_stylus&) = delete;
    hfh_stylus& operator=(const hfh_stylus&) = delete;
    virtual ~hfh_stylus() = default;

    [[nodiscard]] virtual hfh::AnyHapticLoop& loop() noexcept = 0;

    hfh_field* field;
    std::int32_t axes;
    double time = 0; ///< s
};

struct hfh_field {
    explicit hfh_field(std::int32_t turned) noexcept : axes{turned} {}
    hfh_field(const hfh_field&) = delete;
    hfh_field& operator=(const hfh_field&) = delete;
    virtual ~hfh_field() = default;

    /// Null: out of memory.
    [[nodiscard]] virtual hfh_stylus* stylus(const hfh::HapticLoopOptions& options) noexcept = 0;
    virtual void edited(const hfh::VertexRange& samples) noexcept = 0;

    void release() noexcept {
        if (users.fetch_sub(1, std::memory_order_acq_rel) == 1) delete this;
    }

    std::int32_t axes;
    std::int64_t columns = 0, rows = 0;
    std::atomic<int> users{1}; ///< the caller, and each stylus
};

namespace {

template <hfh::Sample S>
using Grid = hfh::BilinearGrid<double, hfh::HeightView<S, NoData<S>>>;
template <hfh::Sample S>
using Field = hfh::BoundedGrid<double, hfh::HeightView<S, NoData<S>>>;

template <hfh::Sample S>
struct StylusOn final : hfh_stylus {
    StylusOn(hfh_field* on, const Field<S>& ground, const hfh::HapticLoopOptions& options) noexcept
        : hfh_stylus{on, on->axes}, loop_{options, ground} {}

    [[nodiscard]] hfh::AnyHapticLoop& loop() noexcept override { return loop_; }

private:
    hfh::FieldLoop<Field<S>, hfh::BallTip> loop_; // without a radius: a point's, to the bit
};

template <hfh::Sample S>
struct FieldOf final : hfh_field {
    using Range = hfh::SampleRange<S>;

    FieldOf(std::int32_t turned, const Grid<S>& grid, std::unique_ptr<Range[]> bounds,
            hfh::Index count) noexcept
        : hfh_field{turned}, ranges_{std::move(bounds)}, field_{grid, ranges_.get(), count} {
        if (count > 0) static_cast<void>(field_.build());
    }

    [[nodiscard]] hfh_stylus* stylus(const hfh::HapticLoopOptions& options) noexcept override {
        return new (std::nothrow) StylusOn<S>{this, field_, options};
    }
    void edited(const hfh::VertexRange& samples) noexcept override {
        static_cast<void>(field_.update(samples));
    }

private:
    std::unique_ptr<Range[]> ranges_;
    Field<S> field_;
};

template <hfh::Sample S>
[[nodiscard]] std::int32_t create(const hfh_field_options& o, hfh_field** made) noexcept {
    NoData<S> no_data;
    if (!read(o, no_data)) return HFH_BAD_ARGUMENT;
    const bool packed = o.column_stride == 0 && o.row_stride == 0;
    hfh::HeightView<S, NoData<S>> heights{static_cast<const S*>(o.samples),
                                          static_cast<hfh::Index>(o.columns),
                                          static_cast<hfh::Index>(o.rows),
                                          static_cast<hfh::Index>(packed ? 1 : o.column_stride),
                                          static_cast<hfh::Index>(packed ? o.columns : o.row_stride),
                                          no_data};
    hfh::GridFrame frame{.origin = {o.origin[0], o.origin[1]},
                         .spacing = {o.spacing[0], o.spacing[1]},
                         .height_scale = o.height_scale == 0 ? 1 : o.height_scale,
                         .height_offset = o.height_offset};
    if (o.axes == HFH_Y_UP_RIGHT) { // rows run along +z, which is -y here
        heights = heights.flipped_rows();
        frame.origin.y = -(o.origin[1] + static_cast<double>(o.rows - 1) * o.spacing[1]);
    }
    const Grid<S> grid{heights, frame};
    switch (grid.status()) {
    case hfh::GridStatus::ok: break;
    case hfh::GridStatus::too_few_samples: return HFH_TOO_FEW_SAMPLES;
    case hfh::GridStatus::bad_spacing: return HFH_BAD_SPACING;
    case hfh::GridStatus::bad_height_scale: return HFH_BAD_HEIGHT_SCALE;
    }
    using Range = hfh::SampleRange<S>;
    const hfh::Index count =
        o.keeps_bounds != 0 ? hfh::MinMaxPyramid<S>::size(heights.columns(), heights.rows()) : 0;
    std::unique_ptr<Range[]> ranges{count > 0 ? new (std::nothrow) Range[static_cast<std::size_t>(count)]
                                              : nullptr};
    if (count > 0 && !ranges) return HFH_OUT_OF_MEMORY;
    *made = new (std::nothrow) FieldOf<S>{o.axes, grid, std::move(ranges), count};
    if (!*made) return HFH_OUT_OF_MEMORY;
    (*made)->columns = o.columns;
    (*made)->rows = o.rows;
    return HFH_OK;
}

void set_zero(double (&v)[3]) noexcept { v[0] = v[1] = v[2] = 0; }

} // namespace

// The constants of the header are those of the library, and all structs are as a C compiler lays them out.
static_assert(HFH_BAD_INPUT == static_cast<int>(hfh::ContactStatus::bad_input) &&
              HFH_BURIED == static_cast<int>(hfh::ContactStatus::buried) &&
              HFH_LEFT_AT_BORDER == static_cast<int>(hfh::ContactStatus::left_at_border));
static_assert(HFH_TRIP_BURIED == static_cast<int>(hfh::GuardTrip::buried) &&
              HFH_TRIP_STALE == static_cast<int>(hfh::GuardTrip::stale) &&
              HFH_TRIP_BURIED + 1 == hfh::guard_trip_count);
static_assert(std::is_trivial_v<hfh_field_options> && std::is_standard_layout_v<hfh_field_options>);
static_assert(sizeof(void*) != 8 || (sizeof(hfh_field_options) == 120 && sizeof(hfh_stylus_options) == 96));
static_assert(sizeof(hfh_material) == 40 && sizeof(hfh_result) == 120);

std::uint32_t hfh_abi() { return HFH_C_ABI; }

#define HFH_C_TEXT_OF(x) #x
#define HFH_C_TEXT(x) HFH_C_TEXT_OF(x)
const char* hfh_version() {
    return HFH_C_TEXT(HFH_VERSION_MAJOR) "." HFH_C_TEXT(HFH_VERSION_MINOR) "." HFH_C_TEXT(HFH_VERSION_PATCH);
}
#undef HFH_C_TEXT
#undef HFH_C_TEXT_OF

const char* hfh_error_name(std::int32_t error) {
    switch (error) {
    case HFH_OK: return "ok";
    case HFH_BAD_ARGUMENT: return "bad_argument";
    case HFH_OUT_OF_MEMORY: return "out_of_memory";
    case HFH_TOO_FEW_SAMPLES: return "too_few_samples";
    case HFH_BAD_SPACING: return "bad_spacing";
    case HFH_BAD_HEIGHT_SCALE: return "bad_height_scale";
    case HFH_BAD_WORKSPACE: return "bad_workspace";
    }
    return "unknown";
}
const char* hfh_status_name(std::int32_t status) {
    return status >= HFH_FREE && status <= HFH_BAD_INPUT ? to_string(static_cast<hfh::ContactStatus>(status))
                                                         : "unknown";
}
const char* hfh_trip_name(std::int32_t trip) {
    return trip >= HFH_TRIP_NONE && trip <= HFH_TRIP_BURIED ? to_string(static_cast<hfh::GuardTrip>(trip))
                                                            : "unknown";
}

std::int32_t hfh_field_create(const hfh_field_options* options, hfh_field** field) {
    if (!field) return HFH_BAD_ARGUMENT;
    *field = nullptr;
    hfh_field_options o;
    if (!read(options, o) || !o.samples || o.axes < HFH_Z_UP || o.axes > HFH_Y_UP_RIGHT)
        return HFH_BAD_ARGUMENT;
    constexpr std::int64_t most = std::int64_t{1} << 31;
    if (o.columns >= most || o.rows >= most) return HFH_BAD_ARGUMENT;
    switch (o.sample_type) {
    case HFH_UINT8: return create<std::uint8_t>(o, field);
    case HFH_UINT16: return create<std::uint16_t>(o, field);
    case HFH_INT16: return create<std::int16_t>(o, field);
    case HFH_INT32: return create<std::int32_t>(o, field);
    case HFH_FLOAT: return create<float>(o, field);
    case HFH_DOUBLE: return create<double>(o, field);
    default: return HFH_BAD_ARGUMENT;
    }
}

std::int32_t hfh_field_edited(hfh_field* field, std::int64_t column_begin, std::int64_t row_begin,
                              std::int64_t column_end, std::int64_t row_end) {
    if (!field) return HFH_BAD_ARGUMENT;
    const auto column = [&](std::int64_t i) {
        return static_cast<hfh::Index>(std::clamp<std::int64_t>(i, 0, field->columns));
    };
    const auto row = [&](std::int64_t j) {
        const auto within = std::clamp<std::int64_t>(j, 0, field->rows);
        return static_cast<hfh::Index>(field->axes == HFH_Y_UP_RIGHT ? field->rows - within : within);
    };
    const hfh::Index one = row(row_begin), other = row(row_end);
    const bool flipped = field->axes == HFH_Y_UP_RIGHT;
    const hfh::VertexRange samples{{column(column_begin), flipped ? other : one},
                                   {column(column_end), flipped ? one : other}};
    if (samples.begin.i < samples.end.i && samples.begin.j < samples.end.j) field->edited(samples);
    return HFH_OK;
}

void hfh_field_destroy(hfh_field* field) {
    if (field) field->release();
}

std::int32_t hfh_stylus_create(hfh_field* field, const hfh_stylus_options* options, hfh_stylus** stylus) {
    if (!stylus) return HFH_BAD_ARGUMENT;
    *stylus = nullptr;
    hfh_stylus_options o;
    hfh_material m;
    if (!field || !read(options, o)) return HFH_BAD_ARGUMENT;
    if (!is_radius(o.radius) || !is_release_speed(o.release_speed)) return HFH_BAD_ARGUMENT;
    hfh::HapticLoopOptions loop;
    if (o.material) {
        if (!read(o.material, m)) return HFH_BAD_ARGUMENT;
        loop.material = material_of(m);
    }
    loop.workspace = {.scale = o.scale == 0 ? 1 : o.scale, .offset = from_axes(field->axes, o.offset)};
    if (check(loop.workspace) != hfh::WorkspaceStatus::ok) return HFH_BAD_WORKSPACE;
    loop.lag = 0.5 + o.delay;
    loop.release_speed = loop_release_speed(o.release_speed);
    loop.limits =
        hfh::guard_limits({.max_force = o.max_force, .rate = o.rate},
                          o.max_stiffness == 0 ? loop.material.stiffness : o.max_stiffness, loop.lag);
    if (!is_usable(loop.limits)) return HFH_BAD_ARGUMENT;
    hfh_stylus* const made = field->stylus(loop);
    if (!made) return HFH_OUT_OF_MEMORY;
    field->users.fetch_add(1, std::memory_order_relaxed);
    made->loop().set_tip_radius(o.radius);
    *stylus = made;
    return HFH_OK;
}

std::int32_t hfh_stylus_update(hfh_stylus* stylus, const double* position, const double* velocity, double dt,
                               hfh_result* result) {
    hfh_result r{};
    const bool has_result = result && result->size >= offsetof(hfh_result, stylus);
    if (!stylus || !position || !has_result) {
        if (has_result) set_zero(result->force);
        return HFH_BAD_ARGUMENT;
    }
    hfh::DeviceSample sample{.time = stylus->time + dt, .position = from_axes(stylus->axes, position)};
    if (velocity) {
        sample.velocity = from_axes(stylus->axes, velocity);
        sample.has_velocity = true;
    }
    if (hfh::is_finite(sample.time)) stylus->time = sample.time;
    hfh::AnyHapticLoop& loop = stylus->loop();
    const hfh::DeviceCommand command = loop.update(sample);
    const hfh::Contact<double> contact = loop.contact();
    r.status = static_cast<std::int32_t>(contact.status);
    r.trip = static_cast<std::int32_t>(loop.force().trip);
    r.touching = contact.touching() ? 1 : 0;
    to_axes(stylus->axes, command.newtons, r.force);
    to_axes(stylus->axes, loop.stylus(), r.stylus);
    to_axes(stylus->axes, contact.proxy, r.proxy);
    to_axes(stylus->axes, contact.normal, r.normal);
    r.depth = contact.depth;
    r.size = result->size;
    std::memcpy(result, &r, std::min<std::size_t>(result->size, sizeof r));
    return HFH_OK;
}

std::int32_t hfh_stylus_set_material(hfh_stylus* stylus, const hfh_material* material) {
    hfh_material m;
    if (!stylus || !read(material, m)) return HFH_BAD_ARGUMENT;
    stylus->loop().set_material(material_of(m));
    return HFH_OK;
}

std::int32_t hfh_stylus_set_radius(hfh_stylus* stylus, double radius) {
    if (!stylus || !is_radius(radius)) return HFH_BAD_ARGUMENT;
    stylus->loop().set_tip_radius(radius);
    return HFH_OK;
}

std::int32_t hfh_stylus_set_release_speed(hfh_stylus* stylus, double release_speed) {
    if (!stylus || !is_release_speed(release_speed)) return HFH_BAD_ARGUMENT;
    stylus->loop().set_release_speed(loop_release_speed(release_speed));
    return HFH_OK;
}

std::int32_t hfh_stylus_reset(hfh_stylus* stylus) {
    if (!stylus) return HFH_BAD_ARGUMENT;
    stylus->loop().reset();
    return HFH_OK;
}

void hfh_stylus_destroy(hfh_stylus* stylus) {
    if (!stylus) return;
    hfh_field* const field = stylus->field;
    delete stylus;
    field->release();
}
