/* Flight software in C99 over plain UDP, without any library: takes part in a lockstep session of
 * ../examples/probe.yaml as 'pilot', opens the throttle at tick 100 and shuts it at tick 300. */
#include <stdio.h>
#include <stdlib.h>

#include "participant.h"

enum { kOpenAt = 100, kShutAt = 300, kPatience_ms = 30000 };

int main(int count, char** arguments) {
  static unlatch_participant p;
  const char* address = count > 1 ? arguments[1] : "127.0.0.1";
  const int port = count > 2 ? atoi(arguments[2]) : 7670;
  if (unlatch_participant_open(&p, "pilot", address, (uint16_t)port) != 0) {
    perror("pilot");
    return 3;
  }
  for (;;) {
    switch (unlatch_participant_poll(&p, kPatience_ms)) {
      case UNLATCH_PARTICIPANT_NOTHING:
        fprintf(stderr, "pilot: no simulator at %s:%d\n", address, port);
        unlatch_participant_close(&p);
        return 1;
      case UNLATCH_PARTICIPANT_REFUSED:
        fprintf(stderr, "pilot: refused, reason %d\n", (int)p.verdict.reason);
        break;
      case UNLATCH_PARTICIPANT_STATE:
        if (p.state.tick == kOpenAt || p.state.tick == kShutAt) {
          const int throttle = unlatch_participant_find(&p, UNLATCH_CATALOG_KIND_CHANNEL, "throttle");
          (void)unlatch_participant_command(&p, throttle, p.state.tick == kOpenAt ? 1 : 0);
        }
        unlatch_participant_answer(&p);
        break;
      case UNLATCH_PARTICIPANT_END:
        printf("pilot: the session ended at tick %lld, x = %.6f m\n", (long long)p.state.tick, p.state.bodies[0].x);
        unlatch_participant_close(&p);
        return p.state.status == UNLATCH_RUN_STATUS_DONE ? 0 : 1;
    }
  }
}
