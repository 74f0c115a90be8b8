#include "record.hpp"

#include "numbers.hpp"

namespace demo {
namespace {

constexpr std::size_t block = std::size_t{1} << 18;

void append(std::string& text, const glm::dvec3& v) {
    for (const double component : {v.x, v.y, v.z}) {
        append_number(text, component);
        text += ',';
    }
}

} // namespace

Record::Record(const std::filesystem::path& file)
    : file_{file}, text_{"t,x,y,z,contact,px,py,pz,nx,ny,nz,fx,fy,fz,patches,status,guard\n"} {}

void Record::add(const Touch& touch) {
    append_number(text_, touch.t);
    text_ += ',';
    append(text_, touch.stylus);
    text_ += touch.contact ? "1," : "0,";
    append(text_, touch.proxy);
    append(text_, touch.normal);
    append(text_, touch.force);
    append_number(text_, touch.patches);
    text_ += ',';
    text_ += touch.status;
    text_ += ',';
    text_ += touch.guard;
    text_ += '\n';
    if (text_.size() >= block) finish();
}

void Record::finish() {
    file_.write(text_);
    text_.clear();
}

} // namespace demo
