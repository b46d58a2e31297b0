/* Part of Simulink's S-function interface that bridge/stacks/unlatch_sfun.c uses, for sfunction_host.c: a block with
 * one input and two output ports. Names and meanings are those of the S-function documentation. */
#ifndef UNLATCH_TEST_SIMSTRUC_H_
#define UNLATCH_TEST_SIMSTRUC_H_

#include <stddef.h>

typedef double real_T;
typedef int int_T;

typedef struct mxArray { /* a text, a number, or a cell array of texts */
  const char* text;
  double number;
  const struct mxArray* cells;
  size_t count;
} mxArray;

enum { kMaxWidth = 8 };

typedef struct SimStruct {
  const mxArray* parameters;
  int parameter_count, expected_parameters, sample_times, pointers, stop;
  real_T input[kMaxWidth], outputs[2][kMaxWidth], sample_time;
  int input_width, output_widths[2];
  void* pointer;
  const char* error;
} SimStruct;

int mxGetString(const mxArray* from, char* to, size_t size);
double mxGetScalar(const mxArray* from);
size_t mxGetNumberOfElements(const mxArray* from);
const mxArray* mxGetCell(const mxArray* from, size_t index);

#define ssSetNumSFcnParams(S, n) ((S)->expected_parameters = (n))
#define ssGetNumSFcnParams(S) ((S)->expected_parameters)
#define ssGetSFcnParamsCount(S) ((S)->parameter_count)
#define ssGetSFcnParam(S, i) (&(S)->parameters[i])
#define ssSetNumInputPorts(S, n) ((n) == 1)
#define ssSetNumOutputPorts(S, n) ((n) == 2)
#define ssSetInputPortWidth(S, port, n) ((S)->input_width = (n))
#define ssSetInputPortRequiredContiguous(S, port, yes) ((void)0)
#define ssSetInputPortDirectFeedThrough(S, port, yes) ((void)0)
#define ssSetOutputPortWidth(S, port, n) ((S)->output_widths[port] = (n))
#define ssSetNumSampleTimes(S, n) ((S)->sample_times = (n))
#define ssSetNumPWork(S, n) ((S)->pointers = (n))
#define ssSetSampleTime(S, i, t) ((S)->sample_time = (t))
#define ssSetOffsetTime(S, i, t) ((void)0)
#define ssSetPWorkValue(S, i, value) ((S)->pointer = (value))
#define ssGetPWorkValue(S, i) ((S)->pointer)
#define ssSetErrorStatus(S, text) ((S)->error = (text))
#define ssSetStopRequested(S, yes) ((S)->stop = (yes))
#define ssGetInputPortRealSignal(S, port) ((S)->input)
#define ssGetOutputPortRealSignal(S, port) ((S)->outputs[port])

#endif /* UNLATCH_TEST_SIMSTRUC_H_ */
