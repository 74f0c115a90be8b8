/* The C interface, from C99: compiled by the C compiler, linked to the shared library and to nothing of C++. */

#include "hfh_c.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static const double not_a_number = (double)NAN, infinite = (double)INFINITY;
static int failures = 0;

#define CHECK(x)                                                                                             \
    do {                                                                                                     \
        if (!(x)) {                                                                                          \
            ++failures;                                                                                      \
            printf("line %d: %s\n", __LINE__, #x);                                                           \
        }                                                                                                    \
    } while (0)
#define NEAR(a, b, by) (fabs((a) - (b)) <= (by))

enum { n = 33 };

/* Level ground at 2 m of n x n samples, 1 m apart, with every 0.5 m of height a step of the sample. */
static int16_t level[n * n];

static hfh_field_options level_options(void) {
    hfh_field_options o;
    int k;
    for (k = 0; k < n * n; ++k) level[k] = 4;
    memset(&o, 0, sizeof o);
    o.size = sizeof o;
    o.sample_type = HFH_INT16;
    o.samples = level;
    o.columns = o.rows = n;
    o.spacing[0] = o.spacing[1] = 1;
    o.height_scale = 0.5;
    return o;
}

static hfh_stylus_options stylus_options(void) {
    hfh_stylus_options o;
    memset(&o, 0, sizeof o);
    o.size = sizeof o;
    return o;
}

static hfh_material material(double stiffness) {
    hfh_material m;
    memset(&m, 0, sizeof m);
    m.size = sizeof m;
    m.stiffness = stiffness;
    return m;
}

/* Axes: which of the three is up, and the sign of the second one of the ground. */
static void put(int axes, double x, double y, double z, double* p) {
    p[0] = x;
    p[1] = axes == HFH_Z_UP ? y : z;
    p[2] = axes == HFH_Z_UP ? z : y;
}

/* Waits above the ground for the guard's ramp, comes down to `z`, and rests there. */
static hfh_result press(hfh_stylus* stylus, int axes, double x, double y, double z) {
    hfh_result r;
    double p[3];
    int k;
    memset(&r, 0, sizeof r);
    r.size = sizeof r;
    for (k = 0; k < 600; ++k) {
        put(axes, x, y, 2.001, p);
        CHECK(hfh_stylus_update(stylus, p, NULL, 0.001, &r) == HFH_OK);
    }
    CHECK(r.status == HFH_FREE && !r.touching && r.trip == HFH_TRIP_NONE);
    for (k = 0; k <= 100; ++k) {
        put(axes, x, y, 2.001 + (z - 2.001) * k / 100, p);
        CHECK(hfh_stylus_update(stylus, p, NULL, 0.001, &r) == HFH_OK);
    }
    for (k = 0; k < 20; ++k) CHECK(hfh_stylus_update(stylus, p, NULL, 0.001, &r) == HFH_OK);
    return r;
}

static void versions_and_names(void) {
    CHECK(hfh_abi() == HFH_C_ABI);
    CHECK(strcmp(hfh_version(), HFH_PROJECT_VERSION) == 0);
    CHECK(strcmp(hfh_error_name(HFH_BAD_SPACING), "bad_spacing") == 0);
    CHECK(strcmp(hfh_error_name(-1), "unknown") == 0);
    CHECK(strcmp(hfh_status_name(HFH_LEFT_AT_HOLE), "left_at_hole") == 0);
    CHECK(strcmp(hfh_status_name(9), "unknown") == 0);
    CHECK(strcmp(hfh_trip_name(HFH_TRIP_JUMP), "jump") == 0);
    CHECK(strcmp(hfh_trip_name(-3), "unknown") == 0);
}

static void presses_on_level_ground(int axes) {
    hfh_field_options o = level_options();
    hfh_stylus_options s = stylus_options();
    hfh_material m = material(200);
    hfh_field* field = NULL;
    hfh_stylus* stylus = NULL;
    hfh_result r;
    const int up = axes == HFH_Z_UP ? 2 : 1;
    double p[3];
    int k;
    o.axes = axes;
    o.keeps_bounds = axes == HFH_Y_UP_LEFT;
    CHECK(hfh_field_create(&o, &field) == HFH_OK);
    CHECK(hfh_stylus_create(field, &s, &stylus) == HFH_OK);
    hfh_field_destroy(field); /* the stylus keeps it */
    r = press(stylus, axes, 5.5, 6.5, 1.995);
    CHECK(r.status == HFH_CONTACT && r.touching == 1);
    CHECK(NEAR(r.force[up], 400 * 0.005, 1e-9) && NEAR(r.force[0], 0, 1e-12) &&
          NEAR(r.force[3 - up], 0, 1e-12));
    CHECK(NEAR(r.normal[up], 1, 1e-12) && NEAR(r.depth, 0.005, 1e-12));
    put(axes, 5.5, 6.5, 2, p);
    for (k = 0; k < 3; ++k) CHECK(NEAR(r.proxy[k], p[k], 1e-12));
    put(axes, 5.5, 6.5, 1.995, p);
    for (k = 0; k < 3; ++k) CHECK(NEAR(r.stylus[k], p[k], 1e-12));

    CHECK(hfh_stylus_set_material(stylus, &m) == HFH_OK);
    for (k = 0; k < 5; ++k) hfh_stylus_update(stylus, p, NULL, 0.001, &r);
    CHECK(NEAR(r.force[up], 200 * 0.005, 1e-9));

    CHECK(hfh_stylus_reset(stylus) == HFH_OK);
    hfh_stylus_update(stylus, p, NULL, 0.001, &r);
    CHECK(r.status == HFH_BURIED && r.trip == HFH_TRIP_BURIED && r.force[up] == 0);

    /* A ball of 10 cm comes to rest that much higher. */
    CHECK(hfh_stylus_set_radius(stylus, 0.1) == HFH_OK);
    put(axes, 5.5, 6.5, 2.2, p);
    for (k = 0; k < 600; ++k) hfh_stylus_update(stylus, p, NULL, 0.001, &r);
    for (k = 0; k <= 105; ++k) {
        put(axes, 5.5, 6.5, 2.2 - 0.001 * k, p);
        hfh_stylus_update(stylus, p, NULL, 0.001, &r);
    }
    for (k = 0; k < 5; ++k) hfh_stylus_update(stylus, p, NULL, 0.001, &r);
    CHECK(r.touching && NEAR(r.depth, 0.005, 1e-9) && NEAR(r.force[up], 1, 1e-6));
    CHECK(NEAR(r.proxy[up], 2.1, 1e-9));

    /* One that grows or shrinks stays in contact, and with the radius 0 it is a point again. */
    CHECK(hfh_stylus_set_radius(stylus, 0.103) == HFH_OK);
    for (k = 0; k < 600; ++k) {
        hfh_stylus_update(stylus, p, NULL, 0.001, &r);
        CHECK(r.touching && r.trip == HFH_TRIP_NONE);
    }
    CHECK(NEAR(r.proxy[up], 2.103, 1e-9) && NEAR(r.force[up], 1.6, 1e-6));
    CHECK(hfh_stylus_set_radius(stylus, 0.097) == HFH_OK);
    hfh_stylus_update(stylus, p, NULL, 0.001, &r);
    CHECK(r.touching && NEAR(r.proxy[up], 2.097, 1e-9));
    CHECK(hfh_stylus_set_radius(stylus, 0) == HFH_OK);
    hfh_stylus_update(stylus, p, NULL, 0.001, &r);
    CHECK(!r.touching);
    put(axes, 5.5, 6.5, 1.995, p);
    hfh_stylus_update(stylus, p, NULL, 0.001, &r);
    CHECK(r.touching && NEAR(r.proxy[up], 2, 1e-12));
    hfh_stylus_destroy(stylus);
}

/* Ground that rises along rows and columns: what is where, in every order of axes and strides. */
static void slopes(int axes, int transposed) {
    static double heights[n * n];
    hfh_field_options o = level_options();
    hfh_stylus_options s = stylus_options();
    hfh_field* field = NULL;
    hfh_stylus* stylus = NULL;
    hfh_result r;
    double length = sqrt(1 + 0.3 * 0.3 + 0.1 * 0.1);
    int i, j, k;
    const int second = axes == HFH_Z_UP ? 1 : 2, up = 3 - second;
    for (j = 0; j < n; ++j)
        for (i = 0; i < n; ++i) heights[transposed ? i * n + j : j * n + i] = 0.3 * (i - 8) + 0.1 * (j - 9);
    o.sample_type = HFH_DOUBLE;
    o.samples = heights;
    o.axes = axes;
    if (transposed) o.column_stride = n, o.row_stride = 1;
    o.height_scale = 1;
    o.height_offset = 2;
    o.origin[0] = -8;
    o.origin[1] = -9;
    CHECK(hfh_field_create(&o, &field) == HFH_OK);
    CHECK(hfh_stylus_create(field, &s, &stylus) == HFH_OK);
    r = press(stylus, axes, -0.01, -0.02, 1.99);
    CHECK(r.touching);
    CHECK(NEAR(r.normal[0], -0.3 / length, 1e-9) && NEAR(r.normal[second], -0.1 / length, 1e-9));
    CHECK(NEAR(r.normal[up], 1 / length, 1e-9));
    for (k = 0; k < 3; ++k) CHECK(NEAR(r.force[k], 400 * r.depth * r.normal[k], 1e-9));
    CHECK(NEAR(r.depth, (2 - 0.3 * 0.01 - 0.1 * 0.02 - 1.99) / length, 1e-9));
    hfh_stylus_destroy(stylus);
    hfh_field_destroy(field);
}

/* A hole by its value, an edit that is told, a scale, and a velocity that is felt as damping. */
static void pieces(void) {
    hfh_field_options o = level_options();
    hfh_stylus_options s = stylus_options();
    hfh_material m = material(400);
    hfh_field* field = NULL;
    hfh_stylus* stylus = NULL;
    hfh_result r;
    double p[3] = {0, 0, -0.005}, v[3] = {0, 0, -0.1};
    int k;
    o.has_no_data = 1;
    o.no_data = -1;
    o.keeps_bounds = 1;
    CHECK(hfh_field_create(&o, &field) == HFH_OK);
    level[20 * n + 20] = -1;
    CHECK(hfh_field_edited(field, 20, 20, 21, 21) == HFH_OK);
    s.scale = 100;
    s.offset[0] = s.offset[1] = 10.5;
    s.offset[2] = 2;
    m.damping = 5;
    s.material = &m;
    CHECK(hfh_stylus_create(field, &s, &stylus) == HFH_OK);
    memset(&r, 0, sizeof r);
    r.size = sizeof r;
    for (k = 0; k < 600; ++k) {
        p[2] = k < 595 ? 0.001 : 0.001 * (595 - k);
        hfh_stylus_update(stylus, p, NULL, 0.001, &r);
    }
    for (k = 0; k < 50; ++k) hfh_stylus_update(stylus, p, NULL, 0.001, &r);
    CHECK(r.touching && NEAR(r.force[2], 1.6, 1e-6) && NEAR(r.depth, 0.4, 1e-9));
    hfh_stylus_update(stylus, p, v, 0.001, &r);
    CHECK(NEAR(r.force[2], 1.6 + 0.5, 1e-6) || NEAR(r.force[2], 1.6 + 0.3 + 3.3 * 0.001 / 0.5, 1e-2));

    /* The ground falls away under the hand, with what is kept of it. */
    for (k = 0; k < n * n; ++k) level[k] = (int16_t)(level[k] - 1);
    CHECK(hfh_field_edited(field, 0, 0, n, n) == HFH_OK);
    hfh_stylus_update(stylus, p, NULL, 0.001, &r);
    CHECK(r.status == HFH_FREE);

    /* Over the hole there is nothing to feel. */
    CHECK(hfh_stylus_reset(stylus) == HFH_OK);
    p[0] = p[1] = 0.0925;
    p[2] = -0.5;
    level[20 * n + 20] = -1;
    CHECK(hfh_field_edited(field, 20, 20, 21, 21) == HFH_OK);
    hfh_stylus_update(stylus, p, NULL, 0.001, &r);
    CHECK(r.status == HFH_OFF_SURFACE);
    hfh_stylus_destroy(stylus);
    hfh_field_destroy(field);
}

/* Below a ridge of 1 m along column 16 to its other side. The longest step of the proxy, which the ridge lets go: that of the release and that of the stylus, 1 mm. */
static double step_at_ridge(hfh_stylus* stylus) {
    hfh_result r;
    double p[3], before = 0, longest = 0;
    int k;
    r = press(stylus, HFH_Z_UP, 13.5, 6.5, 1.995);
    for (k = 0; k <= 500; ++k) {
        put(HFH_Z_UP, 13.5, 6.5, 1.995 - 0.003 * k, p);
        hfh_stylus_update(stylus, p, NULL, 0.001, &r);
    }
    before = r.proxy[0];
    for (k = 0; k <= 7000; ++k) {
        put(HFH_Z_UP, 13.5 + 0.001 * k, 6.5, 0.5, p);
        hfh_stylus_update(stylus, p, NULL, 0.001, &r);
        CHECK(r.touching);
        longest = fmax(longest, fabs(r.proxy[0] - before));
        before = r.proxy[0];
    }
    CHECK(NEAR(r.proxy[0], 20.5, 1e-3));
    return longest;
}

static void glides_off_a_ridge(void) {
    hfh_field_options o = level_options();
    hfh_stylus_options s = stylus_options();
    hfh_field* field = NULL;
    hfh_stylus* stylus = NULL;
    int k;
    for (k = 0; k < n; ++k) level[k * n + 16] = 6;
    CHECK(hfh_field_create(&o, &field) == HFH_OK);
    CHECK(hfh_stylus_create(field, &s, &stylus) == HFH_OK);
    CHECK(step_at_ridge(stylus) > 1);
    CHECK(hfh_stylus_set_release_speed(stylus, 0.005) == HFH_OK);
    CHECK(hfh_stylus_reset(stylus) == HFH_OK);
    CHECK(step_at_ridge(stylus) < 0.006001);
    CHECK(hfh_stylus_set_release_speed(stylus, 0) == HFH_OK);
    CHECK(hfh_stylus_reset(stylus) == HFH_OK);
    CHECK(step_at_ridge(stylus) > 1);
    CHECK(hfh_stylus_set_release_speed(stylus, -1) == HFH_BAD_ARGUMENT);
    CHECK(hfh_stylus_set_release_speed(stylus, infinite) == HFH_BAD_ARGUMENT);
    CHECK(hfh_stylus_set_release_speed(NULL, 0.001) == HFH_BAD_ARGUMENT);
    hfh_stylus_destroy(stylus);

    s.release_speed = 0.005;
    s.scale = 1;
    CHECK(hfh_stylus_create(field, &s, &stylus) == HFH_OK);
    CHECK(step_at_ridge(stylus) < 0.006001);
    hfh_stylus_destroy(stylus);
    /* Of a program whose header did not have it yet. */
    s.size = (uint32_t)((char*)&s.release_speed - (char*)&s);
    CHECK(hfh_stylus_create(field, &s, &stylus) == HFH_OK);
    CHECK(step_at_ridge(stylus) > 1);
    hfh_stylus_destroy(stylus);
    s.size = sizeof s;
    s.release_speed = not_a_number;
    CHECK(hfh_stylus_create(field, &s, &stylus) == HFH_BAD_ARGUMENT && stylus == NULL);
    hfh_field_destroy(field);
}

static void bad_arguments(void) {
    hfh_field_options o = level_options(), bad;
    hfh_stylus_options s = stylus_options(), bad_s;
    hfh_material m = material(1);
    hfh_field* field = NULL;
    hfh_stylus* stylus = NULL;
    hfh_result r;
    double p[3] = {1, 1, 3};
    struct {
        hfh_field_options known;
        double unknown;
    } longer;
    struct {
        hfh_result known;
        double unknown;
    } longer_result;

    CHECK(hfh_field_create(&o, NULL) == HFH_BAD_ARGUMENT);
    CHECK(hfh_field_create(NULL, &field) == HFH_BAD_ARGUMENT && field == NULL);
#define REFUSED(change, error)                                                                               \
    bad = o;                                                                                                 \
    change;                                                                                                  \
    field = (hfh_field*)&o;                                                                                  \
    CHECK(hfh_field_create(&bad, &field) == error);                                                          \
    CHECK(field == NULL)
    REFUSED(bad.size = 0, HFH_BAD_ARGUMENT);
    REFUSED(bad.samples = NULL, HFH_BAD_ARGUMENT);
    REFUSED(bad.sample_type = 6, HFH_BAD_ARGUMENT);
    REFUSED(bad.axes = 3, HFH_BAD_ARGUMENT);
    REFUSED(bad.columns = 1, HFH_TOO_FEW_SAMPLES);
    REFUSED(bad.rows = -4, HFH_TOO_FEW_SAMPLES);
    REFUSED(bad.columns = (int64_t)1 << 40, HFH_BAD_ARGUMENT);
    REFUSED(bad.spacing[1] = 0, HFH_BAD_SPACING);
    REFUSED(bad.origin[0] = not_a_number, HFH_BAD_SPACING);
    REFUSED(bad.height_offset = infinite, HFH_BAD_HEIGHT_SCALE);
    REFUSED((bad.has_no_data = 1, bad.no_data = 0.5), HFH_BAD_ARGUMENT);
    REFUSED((bad.has_no_data = 1, bad.no_data = 70000), HFH_BAD_ARGUMENT);

    /* Structs of later and of earlier headers. */
    memset(&longer, 0, sizeof longer);
    longer.known = o;
    longer.known.size = sizeof longer;
    CHECK(hfh_field_create(&longer.known, &field) == HFH_OK);
    hfh_field_destroy(field);
    longer.unknown = 1;
    CHECK(hfh_field_create(&longer.known, &field) == HFH_BAD_ARGUMENT);
    bad = o;
    bad.size = (uint32_t)((char*)&bad.keeps_bounds - (char*)&bad);
    bad.keeps_bounds = 77;
    CHECK(hfh_field_create(&bad, &field) == HFH_OK);
    if (!field) return;

    CHECK(hfh_stylus_create(field, &s, NULL) == HFH_BAD_ARGUMENT);
    CHECK(hfh_stylus_create(NULL, &s, &stylus) == HFH_BAD_ARGUMENT && stylus == NULL);
    CHECK(hfh_stylus_create(field, NULL, &stylus) == HFH_BAD_ARGUMENT);
    bad_s = s;
    bad_s.scale = -1;
    CHECK(hfh_stylus_create(field, &bad_s, &stylus) == HFH_BAD_WORKSPACE);
    bad_s = s;
    bad_s.radius = not_a_number;
    CHECK(hfh_stylus_create(field, &bad_s, &stylus) == HFH_BAD_ARGUMENT);
    bad_s = s;
    bad_s.delay = not_a_number;
    CHECK(hfh_stylus_create(field, &bad_s, &stylus) == HFH_BAD_ARGUMENT && stylus == NULL);
    CHECK(hfh_stylus_create(field, &s, &stylus) == HFH_OK);
    if (!stylus) return;

    memset(&r, 0, sizeof r);
    r.size = sizeof r;
    r.force[0] = 5;
    CHECK(hfh_stylus_update(stylus, NULL, NULL, 0.001, &r) == HFH_BAD_ARGUMENT && r.force[0] == 0);
    CHECK(hfh_stylus_update(NULL, p, NULL, 0.001, &r) == HFH_BAD_ARGUMENT);
    CHECK(hfh_stylus_update(stylus, p, NULL, 0.001, NULL) == HFH_BAD_ARGUMENT);
    CHECK(hfh_stylus_update(stylus, p, NULL, 0.001, &r) == HFH_OK && r.size == sizeof r);
    p[1] = not_a_number;
    CHECK(hfh_stylus_update(stylus, p, NULL, 0.001, &r) == HFH_OK && r.status == HFH_BAD_INPUT);
    CHECK(r.trip == HFH_TRIP_BAD_SAMPLE);
    p[1] = 1;
    CHECK(hfh_stylus_update(stylus, p, NULL, not_a_number, &r) == HFH_OK && r.trip == HFH_TRIP_BAD_SAMPLE);
    CHECK(hfh_stylus_update(stylus, p, NULL, 0.001, &r) == HFH_OK && r.trip == HFH_TRIP_NONE);
    CHECK(hfh_stylus_update(stylus, p, NULL, 1, &r) == HFH_OK && r.trip == HFH_TRIP_STALE);
    /* A longer result is written as far as it is known, a shorter one no farther than it goes. */
    memset(&longer_result, 0x55, sizeof longer_result);
    longer_result.known.size = sizeof longer_result;
    CHECK(hfh_stylus_update(stylus, p, NULL, 0.001, &longer_result.known) == HFH_OK);
    CHECK(longer_result.known.depth == 0 && longer_result.unknown != 0);
    r.depth = 77;
    r.size = (uint32_t)((char*)&r.depth - (char*)&r);
    CHECK(hfh_stylus_update(stylus, p, NULL, 0.001, &r) == HFH_OK && r.depth == 77);
    r.size = 8;
    CHECK(hfh_stylus_update(stylus, p, NULL, 0.001, &r) == HFH_BAD_ARGUMENT);

    m.size = 4;
    CHECK(hfh_stylus_set_material(stylus, &m) == HFH_BAD_ARGUMENT);
    CHECK(hfh_stylus_set_material(stylus, NULL) == HFH_BAD_ARGUMENT);
    CHECK(hfh_stylus_set_radius(stylus, -1) == HFH_BAD_ARGUMENT);
    CHECK(hfh_stylus_set_radius(stylus, not_a_number) == HFH_BAD_ARGUMENT);
    CHECK(hfh_stylus_set_radius(stylus, 1e300) == HFH_BAD_ARGUMENT);
    CHECK(hfh_stylus_reset(NULL) == HFH_BAD_ARGUMENT);
    CHECK(hfh_field_edited(NULL, 0, 0, 1, 1) == HFH_BAD_ARGUMENT);
    CHECK(hfh_field_edited(field, -5, 40, 99, 99) == HFH_OK);
    hfh_field_destroy(NULL);
    hfh_stylus_destroy(NULL);
    hfh_field_destroy(field);
    hfh_stylus_destroy(stylus);
}

/* Level ground of 2 m in one type of sample. Returns the scale of its heights. */
static double fill(int type, void* samples) {
    int k;
    for (k = 0; k < n * n; ++k) {
        switch (type) {
        case HFH_UINT8: ((uint8_t*)samples)[k] = 200; break;
        case HFH_UINT16: ((uint16_t*)samples)[k] = 40000; break;
        case HFH_INT16: ((int16_t*)samples)[k] = -20; break;
        case HFH_INT32: ((int32_t*)samples)[k] = -2000000; break;
        case HFH_FLOAT: ((float*)samples)[k] = 0.25f; break;
        default: ((double*)samples)[k] = 0.125; break;
        }
    }
    switch (type) {
    case HFH_UINT8: return 0.01;
    case HFH_UINT16: return 0.00005;
    case HFH_INT16: return -0.1;
    case HFH_INT32: return -0.000001;
    case HFH_FLOAT: return 8;
    default: return 16;
    }
}

/* The same ground in every type of sample. */
static void types(void) {
    static double samples[n * n]; /* room for each of them */
    int type;
    for (type = HFH_UINT8; type <= HFH_DOUBLE; ++type) {
        hfh_field_options o = level_options();
        hfh_stylus_options s = stylus_options();
        hfh_field* field = NULL;
        hfh_stylus* stylus = NULL;
        hfh_result r;
        o.sample_type = type;
        o.samples = samples;
        o.height_scale = fill(type, samples);
        CHECK(hfh_field_create(&o, &field) == HFH_OK);
        CHECK(hfh_stylus_create(field, &s, &stylus) == HFH_OK);
        r = press(stylus, HFH_Z_UP, 5.5, 6.5, 1.995);
        CHECK(r.touching && NEAR(r.force[2], 2, 1e-9));
        hfh_stylus_destroy(stylus);
        hfh_field_destroy(field);
    }
}

int main(void) {
    int axes;
    versions_and_names();
    for (axes = HFH_Z_UP; axes <= HFH_Y_UP_RIGHT; ++axes) {
        presses_on_level_ground(axes);
        slopes(axes, 0);
        slopes(axes, 1);
    }
    pieces();
    glides_off_a_ridge();
    bad_arguments();
    types();
    printf("%d failures\n", failures);
    return failures > 0;
}
