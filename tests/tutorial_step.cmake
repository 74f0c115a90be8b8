# Run by CTest: PROGRAM succeeds and prints what PAGE says of SOURCE, and every cpp block of that step is a part of SOURCE, but
# for the indentation.
cmake_minimum_required(VERSION 3.25)
cmake_path(GET SOURCE FILENAME name)
execute_process(COMMAND ${PROGRAM} OUTPUT_VARIABLE printed COMMAND_ERROR_IS_FATAL ANY)

file(READ ${PAGE} page)
string(FIND "${page}" "[`${name}`](${name}) prints\n\n```text\n${printed}```\n" end)
if(end EQUAL -1)
    message(FATAL_ERROR "${PAGE} does not say that ${name} prints\n${printed}")
endif()
string(SUBSTRING "${page}" 0 ${end} step)
string(FIND "${step}" "\n## " start REVERSE)
string(SUBSTRING "${step}" ${start} -1 step)

include(${CMAKE_CURRENT_LIST_DIR}/quotes.cmake)
