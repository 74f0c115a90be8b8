# Run by CTest: a compiler that is told to take SOURCE for C++17 says that hfh needs C++20, and then nothing but that a
# file is not there, which is how the header stops it.
execute_process(COMMAND ${CXX} -std=c++17 -fsyntax-only -I ${INCLUDE} ${SOURCE}
    RESULT_VARIABLE result ERROR_VARIABLE complaints)
string(REGEX MATCHALL "[^\n]*error:[^\n]*" errors "${complaints}")
list(LENGTH errors count)
if(result EQUAL 0 OR NOT complaints MATCHES "error: [^\n]*hfh needs C\\+\\+20: " OR NOT count EQUAL 2)
    message(FATAL_ERROR "as C++17 the compiler says\n${complaints}")
endif()
