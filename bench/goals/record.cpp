#include "record.hpp"

#include "text.hpp"

#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <ostream>

// goals.json is written one number a line, so that it can be read back by lines and compared by people.

namespace hfh::bench {
namespace {

std::string quoted(const std::string& plain) {
    std::string out = "\"";
    for (const char c : plain) {
        if (c == '"' || c == '\\') out += '\\';
        out += c;
    }
    return out + '"';
}

/// What follows "key": in a line; none if it is not there.
std::optional<std::string> after(const std::string& line, const std::string& key) {
    const std::string begin = "\"" + key + "\": ";
    const auto at = line.find(begin);
    if (at == line.npos) return {};
    return line.substr(at + begin.size());
}
std::string string_of(const std::string& line, const std::string& key) {
    const auto rest = after(line, key);
    std::string plain;
    if (!rest || rest->front() != '"') return plain;
    for (std::size_t k = 1; k < rest->size() && (*rest)[k] != '"'; ++k) {
        if ((*rest)[k] == '\\' && k + 1 < rest->size()) ++k;
        plain += (*rest)[k];
    }
    return plain;
}
std::optional<double> number_of(const std::string& line, const std::string& key) {
    const auto rest = after(line, key);
    if (!rest) return {};
    char* end = nullptr;
    const double number = std::strtod(rest->c_str(), &end);
    if (end == rest->c_str()) return {}; // null
    return number;
}
bool is_true(const std::string& line, const std::string& key) {
    return after(line, key).value_or("").starts_with("true");
}

const char* in_words(Figure::Goal goal) {
    switch (goal) {
    case Figure::Goal::at_most: return "at most";
    case Figure::Goal::below: return "below";
    case Figure::Goal::at_least: return "at least";
    case Figure::Goal::more_than: return "more than";
    }
    return "";
}

std::string measured(const Row& row) {
    if (std::none_of(row.figures.begin(), row.figures.end(), [](const Figure& f) { return f.measured; })) {
        return "not measured";
    }
    std::string out;
    for (const auto& f : row.figures) {
        out += (out.empty() ? "" : " / ") + (f.measured ? text(*f.measured) : std::string{"–"});
    }
    return out + (row.unit.empty() ? "" : " ") + row.unit;
}
std::string goal(const Row& row) {
    std::string out = in_words(row.figures.front().goal);
    bool same = true;
    for (const auto& f : row.figures) same = same && f.bound == row.figures.front().bound;
    for (std::size_t k = 0; k < (same ? 1 : row.figures.size()); ++k) {
        out += (k == 0 ? " " : " / ") + text(row.figures[k].bound);
    }
    return out;
}

} // namespace

Record read_record(const std::string& path) {
    Record record;
    std::ifstream file{path};
    std::string beside, date; // of the row that a line goes on with
    for (std::string line; std::getline(file, line);) {
        if (after(line, "cpu")) {
            record.machine = {string_of(line, "cpu"), string_of(line, "compiler"), string_of(line, "flags")};
        } else if (after(line, "row")) {
            if (after(line, "date")) beside = string_of(line, "beside"), date = string_of(line, "date");
            record.numbers[{string_of(line, "row"), string_of(line, "figure")}] = {
                number_of(line, "measured"), is_true(line, "held"), beside, date};
        } else if (after(line, "workload")) {
            record.workloads.push_back({string_of(line, "workload"), string_of(line, "ground"),
                                        number_of(line, "cells").value_or(0),
                                        number_of(line, "mean_ns").value_or(0), number_of(line, "worst_ns")});
        }
    }
    return record;
}

void hold(std::vector<Row>& rows, const Record& before) {
    for (auto& row : rows) {
        for (auto& f : row.figures) {
            const auto last = before.numbers.find({row.name, f.what});
            f.held = f.met() || (last != before.numbers.end() && last->second.held);
        }
    }
}

void take_over(Findings& now, const Record& before, const Machine& machine) {
    if (before.machine != machine) return;
    for (auto& row : now.rows) {
        if (std::any_of(row.figures.begin(), row.figures.end(), [](const Figure& f) { return f.measured; })) {
            continue;
        }
        for (auto& f : row.figures) {
            const auto last = before.numbers.find({row.name, f.what});
            if (last == before.numbers.end() || !last->second.measured) continue;
            f.measured = last->second.measured;
            row.beside = last->second.beside;
            row.date = last->second.date;
        }
    }
    for (const auto& w : before.workloads) {
        const bool renewed =
            std::any_of(now.workloads.begin(), now.workloads.end(), [&w](const Workload& other) {
                return other.name == w.name && other.ground == w.ground && other.cells == w.cells;
            });
        if (!renewed) now.workloads.push_back(w);
    }
}

void write_json(std::ostream& out, const Machine& machine, const Findings& found) {
    out << "{\"machine\": {\"cpu\": " << quoted(machine.cpu) << ", \"compiler\": " << quoted(machine.compiler)
        << ", \"flags\": " << quoted(machine.flags) << "},\n"
        << " \"goals\": [";
    const char* comma = "\n";
    for (const auto& row : found.rows) {
        for (const auto& f : row.figures) {
            out << comma << "  {\"row\": " << quoted(row.name) << ", \"figure\": " << quoted(f.what)
                << ", \"measured\": "
                << (f.measured && std::isfinite(*f.measured) ? text(*f.measured, 4) : "null")
                << ", \"goal\": \"" << in_words(f.goal) << "\", \"bound\": " << text(f.bound)
                << ", \"unit\": " << quoted(row.unit) << ", \"met\": " << (f.met() ? "true" : "false")
                << ", \"held\": " << (f.held ? "true" : "false");
            if (&f == &row.figures.front()) {
                out << ", \"date\": " << quoted(row.date) << ", \"beside\": " << quoted(row.beside);
            }
            out << "}";
            comma = ",\n";
        }
    }
    out << "\n ],\n \"workloads\": [";
    comma = "\n";
    for (const auto& w : found.workloads) {
        out << comma << "  {\"workload\": " << quoted(w.name) << ", \"ground\": " << quoted(w.ground)
            << ", \"cells\": " << text(w.cells, 10) << ", \"mean_ns\": " << text(w.mean_ns, 4);
        if (w.worst_ns) out << ", \"worst_ns\": " << text(*w.worst_ns, 4);
        out << "}";
        comma = ",\n";
    }
    out << "\n ]}\n";
}

void write_markdown(std::ostream& out, const Machine& machine, const Findings& found) {
    std::string first, last; // dates, which sort as text
    for (const auto& row : found.rows) {
        if (row.date.empty()) continue;
        if (first.empty() || row.date < first) first = row.date;
        last = std::max(last, row.date);
    }
    out << machine.cpu << ", one core; " << machine.compiler << ", `" << machine.flags << "`; " << first
        << (first == last ? "" : " to " + last)
        << ". `double` where nothing else is said; subject and reference in turn, in slices, in one "
           "process.\n\n"
        << "| what | measured | goal | met |\n|---|--:|--:|---|\n";
    for (const auto& row : found.rows) {
        out << "| " << row.name << " | " << measured(row) << " | " << goal(row) << " | " << row.verdict()
            << " |\n";
    }
    out << "\nWhat the figures are made of:\n\n| what | |\n|---|---|\n";
    for (const auto& row : found.rows) {
        if (row.beside.empty()) continue;
        out << "| " << row.name << " | " << row.beside;
        if (row.date != last) out << "; " << row.date;
        out << " |\n";
    }
    if (found.workloads.empty()) return;
    out << "\nOne update, nanoseconds, mean / worst of all by replay:\n\n";
    std::vector<std::string> names, grounds;
    const auto ground_of = [](const Workload& w) {
        return w.ground + ", " + text(w.cells / 1e6) + " M cells";
    };
    const auto add = [](std::vector<std::string>& list, const std::string& name) {
        if (std::find(list.begin(), list.end(), name) == list.end()) list.push_back(name);
    };
    for (const auto& w : found.workloads) add(names, w.name), add(grounds, ground_of(w));
    out << "| ground |";
    for (const auto& name : names) out << ' ' << name << " |";
    out << "\n|---|";
    for (std::size_t k = 0; k < names.size(); ++k) out << "--:|";
    out << '\n';
    for (const auto& ground : grounds) {
        out << "| " << ground << " |";
        for (const auto& name : names) {
            for (const auto& w : found.workloads) {
                if (w.name != name || ground_of(w) != ground) continue;
                out << ' ' << text(w.mean_ns) << " / " << text(w.worst_ns.value_or(0));
            }
            out << " |";
        }
        out << '\n';
    }
}

void print(const Row& row) {
    std::printf("%s\n    %s, goal %s: %s\n", row.name.c_str(), measured(row).c_str(), goal(row).c_str(),
                row.verdict());
    if (!row.beside.empty()) std::printf("    %s\n", row.beside.c_str());
    std::fflush(stdout);
}

} // namespace hfh::bench
