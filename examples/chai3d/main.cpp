// A terrain in CHAI3D, touched by a tool: by the first haptic device that is found, or, with --compare, by a tool that is
// dragged over it without a device, once with hfh in the place of its finger proxy and once as CHAI3D does it on a mesh
// of the same samples.

#include "height_field_proxy.hpp"

#include <hfh/terrain/bilinear_grid.hpp>

#include <algorithm>
#include <array>
#include <atomic>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <numbers>
#include <string_view>
#include <thread>
#include <vector>

namespace {

constexpr hfh::Index columns = 401, rows = 401;
constexpr double spacing = 0.005; // m of the world between samples
constexpr double half_x = 0.5 * spacing * (columns - 1), half_y = 0.5 * spacing * (rows - 1);

std::vector<float> make_heights() {
    std::vector<float> heights;
    for (hfh::Index j = 0; j < rows; ++j) {
        for (hfh::Index i = 0; i < columns; ++i) {
            const auto x = static_cast<double>(i), y = static_cast<double>(j);
            double z = 0;
            // Ridges and hollows down to a few cells.
            for (const double k : {0.03, 0.071, 0.19, 0.43, 0.97})
                z += 0.0035 / k * std::sin(k * x + 2 * std::sin(0.7 * k * y)) * std::cos(k * y) * 0.3;
            heights.push_back(static_cast<float>(z));
        }
    }
    return heights;
}

/// Two triangles a cell, to be drawn; and for CHAI3D's own proxy to feel.
chai3d::cMesh* make_mesh(const std::vector<float>& heights) {
    auto* mesh = new chai3d::cMesh();
    const auto vertex = [&](hfh::Index i, hfh::Index j) {
        return chai3d::cVector3d(spacing * static_cast<double>(i) - half_x,
                                 spacing * static_cast<double>(j) - half_y,
                                 static_cast<double>(heights[static_cast<std::size_t>(i + j * columns)]));
    };
    for (hfh::Index j = 0; j < rows; ++j)
        for (hfh::Index i = 0; i < columns; ++i) mesh->newVertex(vertex(i, j));
    const auto number = [](hfh::Index i, hfh::Index j) { return static_cast<unsigned>(i + j * columns); };
    for (hfh::Index j = 0; j + 1 < rows; ++j) {
        for (hfh::Index i = 0; i + 1 < columns; ++i) {
            mesh->newTriangle(number(i, j), number(i + 1, j), number(i + 1, j + 1));
            mesh->newTriangle(number(i, j), number(i + 1, j + 1), number(i, j + 1));
        }
    }
    mesh->computeAllNormals();
    mesh->m_material->setStiffness(400); // N/m
    return mesh;
}

using Grid = hfh::BilinearGrid<double, hfh::HeightView<float>>;

Grid make_grid(const std::vector<float>& heights) {
    return {hfh::HeightView{heights.data(), columns, rows},
            {.origin = {-half_x, -half_y}, .spacing = {spacing, spacing}}};
}

/// z of the bilinear surface, or of the two triangles, at a place.
double height(const Grid& grid, bool triangles, double x, double y) {
    const double u = grid.lattice().u_of(x, 0), v = grid.lattice().v_of(y, 0);
    const hfh::Cell cell{static_cast<hfh::Index>(std::floor(u)), static_cast<hfh::Index>(std::floor(v))};
    const auto patch = grid.patch(cell);
    if (!patch) return -1e9;
    const double a = u - static_cast<double>(cell.i), b = v - static_cast<double>(cell.j);
    if (!triangles) return patch->height(a, b);
    if (a >= b) return patch->p00 + a * (patch->p10 - patch->p00) + b * (patch->p11 - patch->p10);
    return patch->p00 + b * (patch->p01 - patch->p00) + a * (patch->p11 - patch->p01);
}

/// Whether from the surface at the proxy a ten-thousandth of a cell to some side leads nearer to the device. (The proxy itself may be
/// a little above the surface: CHAI3D keeps it there.)
bool is_off_minimum(const Grid& grid, bool triangles, const chai3d::cVector3d& proxy,
                    const chai3d::cVector3d& device) {
    const auto distance = [&](double x, double y) {
        return (chai3d::cVector3d(x, y, height(grid, triangles, x, y)) - device).length();
    };
    const double here = distance(proxy.x(), proxy.y()), step = 1e-4 * spacing;
    for (int k = 0; k < 32; ++k) {
        const double angle = k * std::numbers::pi / 16;
        if (distance(proxy.x() + step * std::cos(angle), proxy.y() + step * std::sin(angle)) <
            here - 1e-3 * step)
            return true;
    }
    return false;
}

struct Figures {
    double microseconds; ///< mean of an update
    double off_minimum;  ///< share of the updates in contact
    int in_contact, updates;
};

/// Drags a tool of radius `radius` (m) over the terrain, `cells` an update, half a cell deep.
Figures drag(chai3d::cHapticPoint& point, chai3d::cGenericObject& object, const Grid& grid, bool triangles,
             double cells, double radius, int updates) {
    chai3d::cMatrix3d axes;
    axes.identity();
    chai3d::cVector3d none(0, 0, 0);
    chai3d::cVector3d at(0, 0, 1);
    point.initialize(at);
    double seconds = 0, heading = 0.3;
    int off = 0, in_contact = 0;
    for (int n = 0; n < updates; ++n) {
        heading += 0.1 * std::sin(0.013 * n);
        double x = 0, y = 0;
        for (;; heading += 1.7) {
            x = at.x() + cells * spacing * std::cos(heading);
            y = at.y() + cells * spacing * std::sin(heading);
            if (std::abs(x) <= 0.9 * half_x && std::abs(y) <= 0.9 * half_y) break;
        }
        at = chai3d::cVector3d(x, y, n == 0 ? 0.5 : height(grid, false, x, y) + radius - 0.5 * spacing);
        const auto start = std::chrono::steady_clock::now();
        (void)point.computeInteractionForces(at, axes, none, none);
        seconds += std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
        if (!point.isInContact(&object)) continue;
        ++in_contact;
        if (radius > 0) continue; // is_off_minimum judges a point
        off += is_off_minimum(grid, triangles, point.getGlobalPosProxy(), at);
    }
    return {1e6 * seconds / updates, static_cast<double>(off) / std::max(1, in_contact), in_contact, updates};
}

/// A point, and whether it is on the minimum.
void compare_points(chai3d::cHapticPoint& own, chai3d::cHapticPoint& ours, chai3d::cMesh& mesh,
                    const Grid& grid) {
    std::printf(
        "cells an update | CHAI3D's finger proxy: us, in contact, off the minimum | hfh in its place\n");
    for (const double cells : {0.1, 0.5, 2.0}) {
        const Figures a = drag(own, mesh, grid, true, cells, 0, 20000);
        const Figures b = drag(ours, mesh, grid, false, cells, 0, 20000);
        std::printf("%15.1f | %8.2f %6.1f %% %6.1f %% | %8.2f %6.1f %% %6.1f %%\n", cells, a.microseconds,
                    100.0 * a.in_contact / a.updates, 100 * a.off_minimum, b.microseconds,
                    100.0 * b.in_contact / b.updates, 100 * b.off_minimum);
    }
}

/// The medians of the times (us) of three tools, which are dragged in turns.
struct BallTimes {
    double own, dynamic, ours;
};
BallTimes time_balls(chai3d::cToolCursor& own, chai3d::cToolCursor& ours, chai3d::cMesh& mesh,
                     const Grid& grid, double cells, double radius) {
    constexpr std::size_t turns = 7;
    const int updates = cells > 10 ? 500 : 4000;
    std::array<double, turns> times[3];
    const auto time = [&](chai3d::cToolCursor& tool) {
        return drag(*tool.m_hapticPoint, mesh, grid, false, cells, radius, updates).microseconds;
    };
    for (std::size_t turn = 0; turn < turns; ++turn) {
        own.m_hapticPoint->m_algorithmFingerProxy->m_useDynamicProxy = false;
        times[0][turn] = time(own);
        own.m_hapticPoint->m_algorithmFingerProxy->m_useDynamicProxy = true;
        times[1][turn] = time(own);
        times[2][turn] = time(ours);
    }
    for (auto& sorted : times) std::sort(sorted.begin(), sorted.end());
    return {times[0][turns / 2], times[1][turns / 2], times[2][turns / 2]};
}

/// A ball of a cell and one of five.
void compare_balls(chai3d::cToolCursor& own, chai3d::cToolCursor& ours, chai3d::cMesh& mesh,
                   const Grid& grid) {
    std::printf(
        "\nradius, cells | cells an update | CHAI3D's finger proxy: us | its dynamic proxy | hfh in its "
        "place | how many times as fast as the faster one\n");
    for (const double radius : {1.0, 5.0}) {
        own.setRadius(radius * spacing), ours.setRadius(radius * spacing);
        mesh.createAABBCollisionDetector(radius * spacing);
        for (const double cells : {0.5, 5.0, 100.0}) {
            const BallTimes us = time_balls(own, ours, mesh, grid, cells, radius * spacing);
            std::printf("%13.0f | %15.1f | %25.1f | %17.1f | %16.1f | %.1f\n", radius, cells, us.own,
                        us.dynamic, us.ours, std::min(us.own, us.dynamic) / us.ours);
        }
    }
}

void compare(chai3d::cWorld& world, chai3d::cMesh& mesh, const Grid& grid) {
    mesh.createAABBCollisionDetector(0);
    chai3d::cToolCursor own(&world), ours(&world);
    own.setRadius(0), ours.setRadius(0);
    own.m_hapticPoint->initialize(chai3d::cVector3d(0, 0, 1));
    hfh_chai3d::feel(*ours.m_hapticPoint, grid, mesh);
    compare_points(*own.m_hapticPoint, *ours.m_hapticPoint, mesh, grid);
    compare_balls(own, ours, mesh, grid);
}

/// Until Enter. Returns false if there is no device.
bool touch(chai3d::cWorld& world, chai3d::cMesh& mesh, const Grid& grid) {
    chai3d::cHapticDeviceHandler handler;
    chai3d::cGenericHapticDevicePtr device;
    if (!handler.getDevice(device, 0)) return false;
    auto* tool = new chai3d::cToolCursor(&world); // the world deletes it
    world.addChild(tool);
    tool->setHapticDevice(device);
    tool->setWorkspaceRadius(0.7 * half_x);
    tool->setRadius(0.01);
    tool->setWaitForSmallForce(true); // no kick at the start
    mesh.m_material->setStiffness(0.5 * device->getSpecifications().m_maxLinearStiffness /
                                  tool->getWorkspaceScaleFactor());
    hfh_chai3d::feel(*tool->m_hapticPoint, grid, mesh);
    tool->start();

    std::atomic<bool> running{true};
    std::thread haptics{[&] {
        while (running) {
            world.computeGlobalPositions(true);
            tool->updateFromDevice();
            tool->computeInteractionForces();
            tool->applyToDevice();
        }
    }};
    std::puts("Touch the terrain; Enter ends.");
    (void)std::getchar();
    running = false;
    haptics.join();
    tool->stop();
    return true;
}

} // namespace

int main(int count, char** arguments) {
    const bool compares = count == 2 && std::string_view{arguments[1]} == "--compare";
    if (count != 1 && !compares) {
        std::fputs("usage: chai3d_terrain [--compare]\n", stderr);
        return 2;
    }
    const auto heights = make_heights();
    const Grid grid = make_grid(heights);
    chai3d::cWorld world;
    chai3d::cMesh* mesh = make_mesh(heights);
    world.addChild(mesh);
    world.computeGlobalPositions(true);
    if (compares) {
        compare(world, *mesh, grid);
    } else if (!touch(world, *mesh, grid)) {
        std::fputs("chai3d_terrain: no haptic device was found. --compare needs none.\n", stderr);
        return 2;
    }
    return 0;
}
