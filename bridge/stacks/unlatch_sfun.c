/* Level-2 C S-function: an unlatch session as a block. See simulink.md.
 *
 * Each step of the model answers one State: mdlOutputs waits for it and gives its sensors, mdlUpdate sends the inputs
 * as commands of its tick. */
#define S_FUNCTION_NAME unlatch_sfun
#define S_FUNCTION_LEVEL 2

#include <stdlib.h>

#include "participant.h"
#include "simstruc.h"

enum { kName, kAddress, kPort, kChannels, kSensors, kSampleTime, kParameters };
enum { kPatience_ms = 30000, kTextLength = 64 };

/* Number of the item named by cell `index` of a parameter in this session; −1: there is none. */
static int find_item(SimStruct* S, const unlatch_participant* p, int parameter, int kind, size_t index) {
  char name[UNLATCH_WIRE_NAME_LENGTH];
  if (mxGetString(mxGetCell(ssGetSFcnParam(S, parameter), index), name, sizeof name) != 0) return -1;
  return unlatch_participant_find(p, kind, name);
}

static void mdlInitializeSizes(SimStruct* S) {
  ssSetNumSFcnParams(S, kParameters);
  if (ssGetNumSFcnParams(S) != ssGetSFcnParamsCount(S)) return;
  if (!ssSetNumInputPorts(S, 1) || !ssSetNumOutputPorts(S, 2)) return;
  ssSetInputPortWidth(S, 0, (int_T)mxGetNumberOfElements(ssGetSFcnParam(S, kChannels)));
  ssSetInputPortRequiredContiguous(S, 0, 1);
  ssSetInputPortDirectFeedThrough(S, 0, 0);
  ssSetOutputPortWidth(S, 0, (int_T)mxGetNumberOfElements(ssGetSFcnParam(S, kSensors)));
  ssSetOutputPortWidth(S, 1, 1); /* s, simulated time */
  ssSetNumSampleTimes(S, 1);
  ssSetNumPWork(S, 1);
}

static void mdlInitializeSampleTimes(SimStruct* S) {
  ssSetSampleTime(S, 0, mxGetScalar(ssGetSFcnParam(S, kSampleTime)));
  ssSetOffsetTime(S, 0, 0.0);
}

#define MDL_START
static void mdlStart(SimStruct* S) {
  char name[UNLATCH_WIRE_NAME_LENGTH], address[kTextLength];
  unlatch_participant* p = calloc(1, sizeof *p);
  ssSetPWorkValue(S, 0, NULL);
  if (p == NULL || mxGetString(ssGetSFcnParam(S, kName), name, sizeof name) != 0 ||
      mxGetString(ssGetSFcnParam(S, kAddress), address, sizeof address) != 0 ||
      unlatch_participant_open(p, name, address, (uint16_t)mxGetScalar(ssGetSFcnParam(S, kPort))) != 0) {
    free(p);
    ssSetErrorStatus(S, "unlatch: the socket cannot be opened; are name, address (IPv4) and port right?");
    return;
  }
  ssSetPWorkValue(S, 0, p);
}

static void mdlOutputs(SimStruct* S, int_T tid) {
  unlatch_participant* p = ssGetPWorkValue(S, 0);
  real_T *sensors = ssGetOutputPortRealSignal(S, 0), *time = ssGetOutputPortRealSignal(S, 1);
  unlatch_participant_event event;
  size_t i;
  (void)tid;
  do event = unlatch_participant_poll(p, kPatience_ms);
  while (event == UNLATCH_PARTICIPANT_REFUSED); /* counted in the simulator's health as well */
  if (event == UNLATCH_PARTICIPANT_NOTHING) {
    ssSetErrorStatus(S, "unlatch: the simulator is silent");
    return;
  }
  if (event == UNLATCH_PARTICIPANT_END) ssSetStopRequested(S, 1);
  *time = 1e-9 * (double)p->state.time_ns;
  for (i = 0; i < mxGetNumberOfElements(ssGetSFcnParam(S, kSensors)); ++i) {
    const int number = find_item(S, p, kSensors, UNLATCH_CATALOG_KIND_SENSOR, i);
    if (number < 0 || number >= p->state.sensor_count) {
      ssSetErrorStatus(S, "unlatch: the scenario has no sensor of a name in the block's parameters");
      return;
    }
    sensors[i] = p->state.sensors[number];
  }
}

#define MDL_UPDATE
static void mdlUpdate(SimStruct* S, int_T tid) {
  unlatch_participant* p = ssGetPWorkValue(S, 0);
  const real_T* values = ssGetInputPortRealSignal(S, 0);
  size_t i;
  (void)tid;
  if (p->state.status >= UNLATCH_RUN_STATUS_DONE) return;
  for (i = 0; i < mxGetNumberOfElements(ssGetSFcnParam(S, kChannels)); ++i) {
    const int number = find_item(S, p, kChannels, UNLATCH_CATALOG_KIND_CHANNEL, i);
    if (unlatch_participant_command(p, number, values[i]) != 0) {
      ssSetErrorStatus(S, "unlatch: the scenario has no channel of a name in the block's parameters");
      return;
    }
  }
  unlatch_participant_answer(p);
}

static void mdlTerminate(SimStruct* S) {
  unlatch_participant* p = ssGetPWorkValue(S, 0);
  if (p != NULL) unlatch_participant_close(p);
  free(p);
  ssSetPWorkValue(S, 0, NULL);
}

#ifdef MATLAB_MEX_FILE
#include "simulink.c"
#else
#include "cg_sfun.h"
#endif
