# Our own code is compiled with these; they are not part of hfh::hfh, so nobody else gets them.
add_library(hfh_warnings INTERFACE)
target_compile_options(hfh_warnings INTERFACE
    -Wall -Wextra -Wpedantic -Wconversion -Wshadow -Wdouble-promotion -Werror)
