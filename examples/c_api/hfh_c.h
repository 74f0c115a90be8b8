#ifndef HFH_C_H
#define HFH_C_H

/*
 * hfh for C, and for whatever calls C: a height field over your own samples, a stylus on it, and from each position of the
 * device the force on the hand. README.md in this directory shows it in use.
 *
 * Metres, newtons, seconds. Samples are read where they lie and have to outlive the field.
 *
 * Every struct begins with `size`: set it to sizeof the struct and all else to zero where you have no other wish, since zero
 * is each member's default. So a program that was compiled against this header works with a later library, whose structs
 * may be longer. A library that is older than the program refuses a struct in which a member is set that it does not know.
 *
 * Functions give HFH_OK or one of the errors below. None throws. hfh_stylus_update and all of hfh_stylus_set_* and
 * hfh_stylus_reset neither allocate nor wait. A field and its styluses are for one thread at a time: edit samples, and tell of
 * it, between two updates.
 */

#include <stdint.h>

#if defined(_WIN32)
#if defined(HFH_C_BUILDS)
#define HFH_C_API __declspec(dllexport)
#else
#define HFH_C_API __declspec(dllimport)
#endif
#elif defined(__GNUC__)
#define HFH_C_API __attribute__((visibility("default")))
#else
#define HFH_C_API
#endif

#ifdef __cplusplus
extern "C" {
#endif

/* Rises when a function or a struct changes its meaning; not when something is added. */
#define HFH_C_ABI 1
/* HFH_C_ABI of the library that is loaded. */
HFH_C_API uint32_t hfh_abi(void);
/* Of hfh, as "0.2.0". */
HFH_C_API const char* hfh_version(void);

/* Errors. */
#define HFH_OK 0
#define HFH_BAD_ARGUMENT 1 /* a null pointer, a size, or a value that no enumeration below has */
#define HFH_OUT_OF_MEMORY 2
#define HFH_TOO_FEW_SAMPLES 3  /* fewer than 2 columns or rows */
#define HFH_BAD_SPACING 4      /* spacing or origin is out of range or no number */
#define HFH_BAD_HEIGHT_SCALE 5 /* height scale or offset is out of range or no number */
#define HFH_BAD_WORKSPACE 6    /* scale or offset of a stylus is out of range or no number */
HFH_C_API const char* hfh_error_name(int32_t error);

/* What a sample is. */
#define HFH_UINT8 0
#define HFH_UINT16 1
#define HFH_INT16 2
#define HFH_INT32 3
#define HFH_FLOAT 4
#define HFH_DOUBLE 5

/*
 * Which way the axes point of all positions, velocities and forces that go in and out. Columns of samples run along the first
 * axis of the ground, rows along the second.
 */
#define HFH_Z_UP 0       /* right-handed, z up; the ground is x, y */
#define HFH_Y_UP_LEFT 1  /* left-handed, y up, as in Unity; the ground is x, z */
#define HFH_Y_UP_RIGHT 2 /* right-handed, y up, as in OpenGL and OpenHaptics; the ground is x, z */

typedef struct hfh_field_options {
    uint32_t size;
    int32_t sample_type;   /* HFH_UINT8 ... HFH_DOUBLE */
    const void* samples;   /* of column 0, row 0 */
    int64_t columns, rows; /* 2 or more, and less than 2^31 */
    /* From one column or row to the next, in samples, may be below 0. Both 0: row after row without a gap. */
    int64_t column_stride, row_stride;
    double origin[2];     /* m: where column 0, row 0 is on the ground */
    double spacing[2];    /* m between columns, between rows; above 0 */
    double height_scale;  /* m per unit of a sample; 0: 1 */
    double height_offset; /* m */
    int32_t axes;         /* HFH_Z_UP ... */
    int32_t has_no_data;  /* not 0: samples equal to `no_data` are holes; NaN always is */
    double no_data;
    /* Not 0: keeps the lowest and highest samples of blocks, up to a tenth of a byte a sample, for fast long motions. */
    int32_t keeps_bounds;
    int32_t reserved; /* 0 */
} hfh_field_options;

/* How the ground feels in the hand. */
typedef struct hfh_material {
    uint32_t size;
    int32_t shading;        /* not 0: no edges are felt between cells */
    double stiffness;       /* N/m at the hand */
    double static_friction; /* Coulomb's coefficients; both 0: none */
    double dynamic_friction;
    double damping; /* N s/m at the hand, along the normal */
} hfh_material;

typedef struct hfh_stylus_options {
    uint32_t size;
    int32_t reserved;             /* 0 */
    const hfh_material* material; /* NULL: 400 N/m and nothing else */
    double scale;                 /* m of terrain per m of hand; 0: 1 */
    double offset[3];             /* m: where the middle of the device's workspace is on the terrain */
    double radius;                /* m of terrain, of a round tip; 0: a point */
    double max_force;             /* N, of the device; 0: 3.3 */
    double max_stiffness;         /* N/m: the stiffest material that will be set; 0: that of `material` */
    double rate;                  /* updates a second; 0: not told */
    double delay;                 /* updates by which the device acts late; 0: none */
    /* m at the hand an update, at which a proxy glides that a ridge lets go; 0: it does not glide. 0.5e-3 feels smooth. */
    double release_speed;
} hfh_stylus_options;

/* contact: HFH_CONTACT and HFH_DESCENT_LIMIT. */
#define HFH_FREE 0
#define HFH_CONTACT 1
#define HFH_DESCENT_LIMIT 2 /* in contact, and the proxy is on its way */
#define HFH_SWEEP_LIMIT 3   /* free so far, and the search goes on in the next update */
#define HFH_BURIED 4        /* below the ground without having met it: no force until it was outside */
#define HFH_OFF_SURFACE 5   /* beyond the samples or over a hole */
#define HFH_LEFT_AT_BORDER 6
#define HFH_LEFT_AT_HOLE 7
#define HFH_BAD_INPUT 8 /* no number, or too far away: refused */
HFH_C_API const char* hfh_status_name(int32_t status);

/* Why the guard set the force to zero. */
#define HFH_TRIP_NONE 0
#define HFH_TRIP_BAD_LIMITS 1
#define HFH_TRIP_BAD_SAMPLE 2
#define HFH_TRIP_BAD_FORCE 3
#define HFH_TRIP_DEVICE_FAULT 4
#define HFH_TRIP_STALE 5    /* dt is too long */
#define HFH_TRIP_REPEATED 6 /* dt has been 0 for too long */
#define HFH_TRIP_JUMP 7     /* farther than a hand gets in dt */
#define HFH_TRIP_BURIED 8
HFH_C_API const char* hfh_trip_name(int32_t trip);

typedef struct hfh_result {
    uint32_t size;
    int32_t status;   /* HFH_FREE ... */
    int32_t trip;     /* HFH_TRIP_NONE ... */
    int32_t touching; /* 1 in contact, else 0 */
    double force[3];  /* N on the hand until the next update: what the guard let pass */
    double stylus[3]; /* m of terrain */
    double proxy[3];  /* m of terrain; of a round tip its centre; without contact the stylus */
    double normal
        [3]; /* of the ground at the proxy, of a round tip that of its force, of length 1; up without contact */
    double depth; /* m of terrain, from the proxy to the stylus */
} hfh_result;

typedef struct hfh_field hfh_field;
typedef struct hfh_stylus hfh_stylus;

/* *field is NULL after an error. */
HFH_C_API int32_t hfh_field_create(const hfh_field_options* options, hfh_field** field);
/* Samples in [column_begin, column_end) x [row_begin, row_end) have changed; those beyond the field are left out. */
HFH_C_API int32_t hfh_field_edited(hfh_field* field, int64_t column_begin, int64_t row_begin,
                                   int64_t column_end, int64_t row_end);
/* Its styluses may still be used, and so have the samples, until the last of them is destroyed. NULL is allowed. */
HFH_C_API void hfh_field_destroy(hfh_field* field);

/* *stylus is NULL after an error. */
HFH_C_API int32_t hfh_stylus_create(hfh_field* field, const hfh_stylus_options* options, hfh_stylus** stylus);
/*
 * One update: the device is at `position` (m at the hand) and moves with `velocity` (m/s at the hand; NULL: not known), `dt`
 * seconds after the last update. After an error `force` is zero, if there is a result to write it to.
 */
HFH_C_API int32_t hfh_stylus_update(hfh_stylus* stylus, const double* position, const double* velocity,
                                    double dt, hfh_result* result);
/* In the next update, also in contact. */
HFH_C_API int32_t hfh_stylus_set_material(hfh_stylus* stylus, const hfh_material* material);
/* Of the tip, m of terrain; 0: a point. In the next update, also in contact: a ball that grows is lifted, one that shrinks sinks. */
HFH_C_API int32_t hfh_stylus_set_radius(hfh_stylus* stylus, double radius);
/* As `release_speed` of its options. In the next update, also while a proxy glides. */
HFH_C_API int32_t hfh_stylus_set_release_speed(hfh_stylus* stylus, double release_speed);
/* Forgets the stylus and the force: the next position is taken as the first one. */
HFH_C_API int32_t hfh_stylus_reset(hfh_stylus* stylus);
/* NULL is allowed. */
HFH_C_API void hfh_stylus_destroy(hfh_stylus* stylus);

#ifdef __cplusplus
}
#endif

#endif /* HFH_C_H */
