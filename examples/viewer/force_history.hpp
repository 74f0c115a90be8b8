#ifndef VIEWER_FORCE_HISTORY_HPP
#define VIEWER_FORCE_HISTORY_HPP

#include <touch.hpp>

#include <glm/geometric.hpp>

#include <algorithm>
#include <array>
#include <cstddef>

namespace viewer {

/// The force of the last seconds, as a strip chart shows it: the lowest and highest of every few milliseconds.
class ForceHistory {
public:
    static constexpr std::size_t columns = 400;
    static constexpr int updates_in_column = 20;
    static constexpr double seconds = 8;

    struct Column {
        float lowest = 0, highest = 0; ///< N
        bool contact = false;
    };

    void add(const demo::Touch& touch) noexcept {
        const auto newtons = static_cast<float>(glm::length(touch.force));
        if (in_column_ == 0) {
            newest_ = (newest_ + 1) % columns;
            columns_[newest_] = {newtons, newtons, touch.contact};
        }
        Column& column = columns_[newest_];
        column.lowest = std::min(column.lowest, newtons);
        column.highest = std::max(column.highest, newtons);
        column.contact = column.contact || touch.contact;
        in_column_ = (in_column_ + 1) % updates_in_column;
    }
    /// From the oldest, 0, to the newest, columns − 1.
    [[nodiscard]] const Column& operator[](std::size_t k) const noexcept {
        return columns_[(newest_ + 1 + k) % columns];
    }

private:
    std::array<Column, columns> columns_{};
    std::size_t newest_ = 0;
    int in_column_ = 0;
};

} // namespace viewer

#endif // VIEWER_FORCE_HISTORY_HPP
