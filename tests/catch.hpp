#ifndef HFH_TESTS_CATCH_HPP
#define HFH_TESTS_CATCH_HPP

// Catch2 v2 (Debian 12) and v3 (newer systems, or fetched) differ in the name of their header, and v3 keeps Approx in
// its own namespace.

#if __has_include(<catch2/catch_all.hpp>)
#include <catch2/catch_all.hpp>
using Catch::Approx;
#else
#include <catch2/catch.hpp>
#endif

#endif // HFH_TESTS_CATCH_HPP
