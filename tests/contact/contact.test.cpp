#include "catch.hpp"

#include <hfh/contact/contact.hpp>

#include <set>
#include <string>
#include <type_traits>

using namespace hfh;

namespace {

constexpr ContactStatus all[] = {
    ContactStatus::free,           ContactStatus::contact,      ContactStatus::descent_limit,
    ContactStatus::sweep_limit,    ContactStatus::buried,       ContactStatus::off_surface,
    ContactStatus::left_at_border, ContactStatus::left_at_hole, ContactStatus::bad_input};

} // namespace

TEST_CASE("ContactStatus: every status has a name of its own", "[contact]") {
    CHECK(to_string(ContactStatus::free) == std::string{"free"});
    CHECK(to_string(ContactStatus::contact) == std::string{"contact"});
    CHECK(to_string(ContactStatus::descent_limit) == std::string{"descent_limit"});
    CHECK(to_string(ContactStatus::sweep_limit) == std::string{"sweep_limit"});
    CHECK(to_string(ContactStatus::buried) == std::string{"buried"});
    CHECK(to_string(ContactStatus::off_surface) == std::string{"off_surface"});
    CHECK(to_string(ContactStatus::left_at_border) == std::string{"left_at_border"});
    CHECK(to_string(ContactStatus::left_at_hole) == std::string{"left_at_hole"});
    CHECK(to_string(ContactStatus::bad_input) == std::string{"bad_input"});
    CHECK(to_string(static_cast<ContactStatus>(std::size(all))) ==
          std::string{"unknown"}); // and there are no more
    std::set<std::string> names;
    for (const auto status : all) names.insert(to_string(status));
    CHECK(names.size() == std::size(all));
}

TEMPLATE_TEST_CASE("Contact: touches in contact and at the descent's limit only", "[contact]", float,
                   double) {
    for (const auto status : all) {
        Contact<TestType> contact;
        contact.status = status;
        CAPTURE(to_string(status));
        CHECK(contact.touching() ==
              (status == ContactStatus::contact || status == ContactStatus::descent_limit));
    }
}

TEMPLATE_TEST_CASE("Contact: by default nothing is felt", "[contact]", float, double) {
    using T = TestType;
    const Contact<T> contact;
    CHECK_FALSE(contact.touching());
    CHECK(contact.depth == 0);
    CHECK(contact.penetration == vec3<T>{T(0)});
    CHECK(contact.normal == vec3<T>{0, 0, 1});
    CHECK(contact.side == Side::none);
    static_assert(std::is_trivially_copyable_v<Contact<T>>);
}
