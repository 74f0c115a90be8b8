# Run by CTest: the cpp block NUMBER of README, 1 for the first, is a part of EXAMPLE, to the letter, so it compiles and
# stays so.
cmake_minimum_required(VERSION 3.25)

file(READ ${README} readme)
file(READ ${EXAMPLE} example)

set(opening "\n```cpp\n")
string(LENGTH "${opening}" length)
set(program "${readme}")
foreach(block RANGE 1 ${NUMBER})
    string(FIND "${program}" "${opening}" start)
    if(start EQUAL -1)
        message(FATAL_ERROR "${README} has no cpp block ${block}")
    endif()
    math(EXPR start "${start} + ${length}")
    string(SUBSTRING "${program}" ${start} -1 program)
endforeach()
string(FIND "${program}" "```" length)
string(SUBSTRING "${program}" 0 ${length} program)

string(FIND "${example}" "${program}" place)
if(place EQUAL -1 OR program STREQUAL "")
    message(FATAL_ERROR "${EXAMPLE} does not contain this program of README:\n${program}")
endif()
