#ifndef VIEWER_SAVE_TERRAIN_HPP
#define VIEWER_SAVE_TERRAIN_HPP

#include <terrain.hpp>

#include <filesystem>

namespace viewer {

/// Writes the terrain as it is now into a .flt of its own and its .hdr: metres in 32 bit floats. Throws BadInput where the name
/// does not end in .flt, a file of that name is there already, or the system cannot take it.
void save_terrain(const demo::Terrain& terrain, const hfh::GridFrame& frame,
                  const std::filesystem::path& file);

} // namespace viewer

#endif // VIEWER_SAVE_TERRAIN_HPP
