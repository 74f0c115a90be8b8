#ifndef HFH_CONTACT_HPP
#define HFH_CONTACT_HPP

// Where a stylus in contact is felt: the proxy, friction, shading.

#include <hfh/contact/ball_contact.hpp>
#include <hfh/contact/ball_friction.hpp>
#include <hfh/contact/ball_glide.hpp>
#include <hfh/contact/ball_level_change.hpp>
#include <hfh/contact/ball_shading.hpp>
#include <hfh/contact/ball_touches.hpp>
#include <hfh/contact/ball_tracker.hpp>
#include <hfh/contact/contact.hpp>
#include <hfh/contact/force_shading.hpp>
#include <hfh/contact/friction.hpp>
#include <hfh/contact/friction_cone.hpp>
#include <hfh/contact/level_change.hpp>
#include <hfh/contact/proxy_glide.hpp>
#include <hfh/contact/proxy_tracker.hpp>

#endif // HFH_CONTACT_HPP
