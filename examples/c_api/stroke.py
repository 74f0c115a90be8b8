"""stroke.py LIBRARY OUTPUT.svg: strokes over hills through the C interface, and draws stylus, proxy and force."""
import ctypes as c, math, sys

def struct(text):  # "type name, name[n]; ..." as in hfh_c.h
    types = {"u32": c.c_uint32, "i32": c.c_int32, "i64": c.c_int64, "double": c.c_double, "ptr": c.c_void_p}
    fields = []
    for kind, names in (part.split(" ", 1) for part in text.split("; ")):
        for name, _, count in (n.partition("*") for n in names.split(", ")):
            fields.append((name, types[kind] * int(count) if count else types[kind]))
    made = type("Struct", (c.Structure,), {"_fields_": fields})
    return lambda **values: made(size=c.sizeof(made), **values)

Field = struct("u32 size; i32 sample_type; ptr samples; i64 columns, rows, column_stride, row_stride; double origin*2, "
               "spacing*2, height_scale, height_offset; i32 axes, has_no_data; double no_data; i32 keeps_bounds, reserved")
Stylus = struct("u32 size; i32 reserved; ptr material; double scale, offset*3, radius, max_force, max_stiffness, rate, delay, release_speed")
Result = struct("u32 size; i32 status, trip, touching; double force*3, stylus*3, proxy*3, normal*3, depth")

hfh = c.CDLL(sys.argv[1])
hfh.hfh_status_name.restype = c.c_char_p
assert hfh.hfh_abi() == 1
n = 41  # samples, 5 mm apart
heights = (c.c_float * (n * n))(*(0.003 * math.sin(0.5 * (k % n)) * math.cos(0.3 * (k // n)) for k in range(n * n)))
field, stylus, result = c.c_void_p(), c.c_void_p(), Result()
options = Field(sample_type=4, samples=c.cast(heights, c.c_void_p), columns=n, rows=n, spacing=(0.005, 0.005))
assert hfh.hfh_field_create(c.byref(options), c.byref(field)) == 0
assert hfh.hfh_stylus_create(field, c.byref(Stylus(release_speed=0.5e-3)), c.byref(stylus)) == 0

rows = []
for k in range(4000):  # down, along, up: four seconds at 1 kHz
    x, z = 0.02 + 0.04e-3 * k, 0.02 - 0.022 * min(1, 2 * math.sin(math.pi * k / 4000))
    assert hfh.hfh_stylus_update(stylus, (c.c_double * 3)(x, 0.05, z), None, c.c_double(1e-3), c.byref(result)) == 0
    rows.append((x, z, *result.proxy[0:3:2], *result.force, result.touching, hfh.hfh_status_name(result.status).decode()))
hfh.hfh_stylus_destroy(stylus)
hfh.hfh_field_destroy(field)

def line(points, colour):
    text = " ".join(f"{5000 * x:.1f},{y:.1f}" for x, y in points)
    return f'<polyline points="{text}" fill="none" stroke="{colour}" stroke-width="2"/>'

force = [math.hypot(*row[4:7]) for row in rows]
with open(sys.argv[2], "w") as svg:
    svg.write('<svg xmlns="http://www.w3.org/2000/svg" viewBox="80 0 860 420"><rect x="80" width="860" height="420" fill="white"/>'
              + line(((r[0], 160 - 5000 * r[1]) for r in rows), "silver") + line(((r[2], 160 - 5000 * r[3]) for r in rows), "black")
              + line(((r[0], 400 - 40 * f) for r, f in zip(rows, force)), "crimson") + "</svg>\n")
print(f"{sum(r[7] for r in rows)} of {len(rows)} updates in contact, at most {max(force):.3f} N, at the end {rows[-1][8]}")
