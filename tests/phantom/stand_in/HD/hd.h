#ifndef HFH_TESTS_STAND_IN_HD_H
#define HFH_TESTS_STAND_IN_HD_H

/* NOT the vendor's header. Declares, in our own words, the few calls that examples/phantom makes, after the names and
   signatures in the maker's public API reference, so that the adapter can be compiled and tested where the SDK is not.
   The numbers are our own, on purpose different from anybody's, but for the force errors 0x200 to 0x204; nothing may
   depend on them. Built against the real SDK this file is not in the way of it. */

extern "C" {

typedef unsigned HHD;
typedef unsigned HDenum;
typedef unsigned HDerror;
typedef unsigned HDCallbackCode;
typedef unsigned char HDboolean;
typedef unsigned short HDushort;
typedef unsigned long HDSchedulerHandle;
typedef int HDint;
typedef double HDdouble;
typedef const char* HDstring;
#define HDCALLBACK
typedef HDCallbackCode(HDCALLBACK* HDSchedulerCallback)(void*);

typedef struct {
    HDerror errorCode;
    int internalErrorCode;
    HHD hHD;
} HDErrorInfo;

#define HD_INVALID_HANDLE 0xFFFFFFFFu
#define HD_DEFAULT_DEVICE 0
#define HD_MAX_SCHEDULER_PRIORITY 65535

enum {
    HD_SUCCESS = 0,
    HD_WARM_MOTORS = 0x200,
    HD_EXCEEDED_MAX_FORCE,
    HD_EXCEEDED_MAX_FORCE_IMPULSE,
    HD_EXCEEDED_MAX_VELOCITY,
    HD_FORCE_ERROR,
    HD_BAD_HANDLE = 7001,
    HD_DEVICE_FAULT,
    HD_COMM_ERROR,
    HD_COMM_CONFIG_ERROR,
    HD_TIMER_ERROR,
    HD_ILLEGAL_BEGIN,
    HD_ILLEGAL_END,
    HD_FRAME_ERROR,
    HD_SCHEDULER_FULL,
    HD_INVALID_PRIORITY,
    HD_INVALID_ENUM
};
enum { HD_CALLBACK_DONE = 70, HD_CALLBACK_CONTINUE = 71 };
enum { HD_FORCE_OUTPUT = 101, HD_FORCE_RAMPING, HD_MAX_FORCE_CLAMPING };
enum {
    HD_CURRENT_POSITION = 201,
    HD_CURRENT_VELOCITY,
    HD_CURRENT_BUTTONS,
    HD_CURRENT_FORCE,
    HD_NOMINAL_MAX_STIFFNESS,
    HD_NOMINAL_MAX_FORCE,
    HD_UPDATE_RATE,
    HD_USABLE_WORKSPACE_DIMENSIONS,
    HD_CALIBRATION_STYLE,
    HD_NOMINAL_MAX_CONTINUOUS_FORCE,
    HD_SOFTWARE_FORCE_IMPULSE_LIMIT,
    HD_MOTOR_TEMPERATURE,
    HD_CURRENT_INKWELL_SWITCH,
    HD_CURRENT_SAFETY_SWITCH,
    HD_DEVICE_MODEL_TYPE
};
enum { HD_CALIBRATION_OK = 301, HD_CALIBRATION_NEEDS_UPDATE, HD_CALIBRATION_NEEDS_MANUAL_INPUT };
enum { HD_CALIBRATION_ENCODER_RESET = 16, HD_CALIBRATION_AUTO = 32, HD_CALIBRATION_INKWELL = 64 };

HDErrorInfo hdGetError(void);
HHD hdInitDevice(HDstring name);
void hdDisableDevice(HHD device);
void hdMakeCurrentDevice(HHD device);
void hdEnable(HDenum capability);
void hdDisable(HDenum capability);
void hdGetDoublev(HDenum name, HDdouble* values);
void hdGetBooleanv(HDenum name, HDboolean* values);
HDstring hdGetString(HDenum name);
void hdGetIntegerv(HDenum name, HDint* values);
void hdSetDoublev(HDenum name, const HDdouble* values);
void hdBeginFrame(HHD device);
void hdEndFrame(HHD device);
HDenum hdCheckCalibration(void);
void hdUpdateCalibration(HDenum style);
HDSchedulerHandle hdScheduleAsynchronous(HDSchedulerCallback callback, void* user, HDushort priority);
void hdUnschedule(HDSchedulerHandle handle);
void hdStartScheduler(void);
void hdStopScheduler(void);
}

#endif
