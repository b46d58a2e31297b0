// An on-board computer over UDP: separates at 1 s, damps the rates from 1.5 s on. With "slow" it answers each third
// State 8 ms late, beyond the next one.
#define _DEFAULT_SOURCE
#include <stdio.h>
#include <string.h>
#include <unistd.h>

#include "participant.h"

static void control(unlatch_participant* p) {
  static const char* const kWheels[] = {"wheel_x", "wheel_y", "wheel_z"};
  static const char* const kRates[] = {"gyro.x", "gyro.y", "gyro.z"};
  if (p->state.time_ns == 1000000000LL)
    unlatch_participant_command(p, unlatch_participant_find(p, UNLATCH_CATALOG_KIND_CHANNEL, "fire"), 1);
  if (p->state.time_ns <= 1500000000LL) return;
  for (int k = 0; k < 3; ++k) {
    const int wheel = unlatch_participant_find(p, UNLATCH_CATALOG_KIND_CHANNEL, kWheels[k]);
    const int rate = unlatch_participant_find(p, UNLATCH_CATALOG_KIND_SENSOR, kRates[k]);
    unlatch_participant_command(p, wheel, -8 * p->state.sensors[rate]);
  }
}

int main(int argc, char** argv) {
  static unlatch_participant p;
  const int slow = argc > 1 && strcmp(argv[1], "slow") == 0;
  if (unlatch_participant_open(&p, "obc", "127.0.0.1", 7670) != 0) {
    perror("obc");
    return 3;
  }
  for (;;) {
    switch (unlatch_participant_poll(&p, 30000)) {
      case UNLATCH_PARTICIPANT_NOTHING:
        fprintf(stderr, "obc: no simulator\n");
        unlatch_participant_close(&p);
        return 1;
      case UNLATCH_PARTICIPANT_STATE:
        control(&p);
        if (slow && p.state.tick % 3 == 0) usleep(8000);
        unlatch_participant_answer(&p);
        break;
      case UNLATCH_PARTICIPANT_END:
        printf("obc: ended at tick %lld\n", (long long)p.state.tick);
        unlatch_participant_close(&p);
        return 0;
      default:
        break;
    }
  }
}
