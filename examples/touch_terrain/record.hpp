#ifndef TOUCH_TERRAIN_RECORD_HPP
#define TOUCH_TERRAIN_RECORD_HPP

#include "output_file.hpp"
#include "touch.hpp"

#include <string>

namespace demo {

/// Writes one row per update, in digits that read back as the same numbers:
/// `t,x,y,z,contact,px,py,pz,nx,ny,nz,fx,fy,fz,patches,status,guard`, which are the members of `Touch`.
class Record {
public:
    explicit Record(const std::filesystem::path& file);
    void add(const Touch& touch);
    /// Writes what is left; the file stands under its own name from `keep` on.
    void finish();
    void keep() { file_.keep(); }

private:
    OutputFile file_;
    std::string text_;
};

} // namespace demo

#endif // TOUCH_TERRAIN_RECORD_HPP
