#include "../bench/goals/record.hpp"

#include "catch.hpp"

#include <unistd.h>

#include <cstdio>
#include <fstream>
#include <sstream>
#include <string>

// What bench writes down, and when it takes a goal for lost.

using namespace hfh::bench;

namespace {

// Of this process alone: each of these tests may run beside another one.
const std::string file = "goals_record_test_" + std::to_string(::getpid()) + ".json";
const Machine here{"a \"processor\" of 2 \\ 3 GHz", "a compiler", "-O3"};

Row timed(const char* name, double bound, std::optional<double> measured) {
    Row row{name, "ns", {{"first", Figure::Goal::at_most, bound, measured}}};
    row.figures.push_back({"second", Figure::Goal::more_than, 1, 2});
    row.date = "2026-01-02";
    row.beside = "so much \"beside\" it";
    return row;
}

Record written(const Findings& found) {
    {
        std::ofstream out{file};
        write_json(out, here, found);
    }
    Record record = read_record(file);
    std::remove(file.c_str());
    return record;
}

/// One number of "row" measured on later days, each judged by what the day before left.
struct Days {
    Record last;

    /// True if it is lost.
    bool measure(std::optional<double> number) {
        Findings found{{timed("row", 10, number)}};
        hold(found.rows, last);
        last = written(found);
        return found.rows[0].figures[0].lost(slack(found.rows[0]));
    }
};

} // namespace

TEST_CASE("goals record: what is written is read again") {
    Findings found{{timed("row", 10, 7.25), timed("other", 10, {})}, {{"swipes", "hills", 1e9, 12.5, 99.0}}};
    hold(found.rows, {});
    const Record record = written(found);
    CHECK(record.machine == here);
    REQUIRE(record.numbers.size() == 4);
    const Recorded& first = record.numbers.at({"row", "first"});
    CHECK(first.measured == 7.25);
    CHECK(first.held);
    CHECK(first.date == "2026-01-02");
    CHECK(first.beside == "so much \"beside\" it");
    CHECK(record.numbers.at({"row", "second"}).measured == 2);
    CHECK(record.numbers.at({"row", "second"}).date == "2026-01-02");
    CHECK_FALSE(record.numbers.at({"other", "first"}).measured);
    CHECK_FALSE(record.numbers.at({"other", "first"}).held);
    REQUIRE(record.workloads.size() == 1);
    CHECK(record.workloads[0].name == "swipes");
    CHECK(record.workloads[0].ground == "hills");
    CHECK(record.workloads[0].cells == 1e9);
    CHECK(record.workloads[0].mean_ns == 12.5);
    CHECK(record.workloads[0].worst_ns == 99);
}

TEST_CASE("goals record: no file holds nothing") {
    std::remove(file.c_str());
    const Record none = read_record(file);
    CHECK(none.numbers.empty());
    CHECK(none.workloads.empty());
}

TEST_CASE("goals record: a goal that was never met cannot be lost") {
    Days days;
    CHECK_FALSE(days.measure(50));
    CHECK_FALSE(days.measure(60));
}

TEST_CASE("goals record: a goal that was met is lost when it is missed by more than the noise") {
    Days days;
    CHECK_FALSE(days.measure(9));
    CHECK_FALSE(days.measure(10.9));
    CHECK(days.measure(11.1));
}

TEST_CASE("goals record: a lost goal stays lost until it is met again") {
    Days days;
    CHECK_FALSE(days.measure(9));
    CHECK(days.measure(20));
    CHECK(days.measure(20));
    CHECK_FALSE(days.measure({})); // not measured, as where a peer is missing
    CHECK(days.measure(20));
    CHECK_FALSE(days.measure(9));
}

TEST_CASE("goals record: a goal of at least so much is lost from the other side") {
    Figure f{"", Figure::Goal::at_least, 8, 7.3, true};
    CHECK_FALSE(f.met());
    CHECK_FALSE(f.lost(0.1));
    f.measured = 7.1;
    CHECK(f.lost(0.1));
}

TEST_CASE("goals record: a count has no noise") {
    Row row{"state", "bytes", {{"", Figure::Goal::at_most, 192, 200, true}}, "", false};
    CHECK(row.figures[0].lost(slack(row)));
}

TEST_CASE("goals record: a number that is not one is not met") {
    const Figure f{"", Figure::Goal::at_most, 10, std::nan(""), true};
    CHECK_FALSE(f.met());
    CHECK(f.lost(0.1));
}

TEST_CASE("goals record: what a run leaves out is kept from the last one on the same machine") {
    Findings first{{timed("row", 10, 9)},
                   {{"swipes", "hills", 1e9, 12.5, {}}, {"swipes", "moab", 1e6, 11, {}}}};
    const Record before = written(first);

    Findings now{{timed("row", 10, {})}, {{"swipes", "moab", 1e6, 10, {}}}};
    now.rows[0].figures[1].measured.reset();
    now.rows[0].date.clear();
    Findings elsewhere = now;
    take_over(now, before, here);
    CHECK(now.rows[0].figures[0].measured == 9);
    CHECK(now.rows[0].figures[1].measured == 2);
    CHECK(now.rows[0].date == "2026-01-02");
    REQUIRE(now.workloads.size() == 2);
    CHECK(now.workloads[0].mean_ns == 10);
    CHECK(now.workloads[1].ground == "hills");

    take_over(elsewhere, before, {"another processor", here.compiler, here.flags});
    CHECK_FALSE(elsewhere.rows[0].figures[0].measured);
    CHECK(elsewhere.workloads.size() == 1);
}

TEST_CASE("goals record: the table says met or not met, and not measured is not met") {
    Findings found{{timed("fine", 10, 9), timed("bad", 10, 11), timed("absent", 10, {})}};
    found.rows[2].figures[1].measured.reset();
    std::ostringstream table;
    write_markdown(table, here, found);
    CHECK(table.str().find("| fine | 9 / 2 ns | at most 10 / 1 | met |") != std::string::npos);
    CHECK(table.str().find("| bad | 11 / 2 ns | at most 10 / 1 | not met |") != std::string::npos);
    CHECK(table.str().find("| absent | not measured | at most 10 / 1 | not met |") != std::string::npos);
}
