/* The servo's schedule without any work, in C: what this machine and its kernel can do at all.

   usage: baseline PERIOD_NS COUNT SPIN_NS CORE FILE
   CORE is -1 for any. FILE gets four 64-bit integers per wake-up: when it was and how late [ns], how late the sleep
   before its spin ended [ns], how many wake-ups before it were skipped. Prints 1 with realtime priority, else 0. */
#define _GNU_SOURCE
#include <sched.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <sys/mman.h>
#include <sys/prctl.h>
#include <time.h>

static int64_t now(void)
{
    struct timespec t;
    clock_gettime(CLOCK_MONOTONIC, &t);
    return t.tv_sec * 1000000000LL + t.tv_nsec;
}

int main(int argc, char **argv)
{
    if (argc != 6)
        return 2;
    const int64_t period = atoll(argv[1]), count = atoll(argv[2]);
    const int core = atoi(argv[4]);
    struct sched_param priority = {.sched_priority = 80};
    if (core >= 0) {
        cpu_set_t cores;
        CPU_ZERO(&cores);
        CPU_SET(core, &cores);
        sched_setaffinity(0, sizeof cores, &cores);
    }
    prctl(PR_SET_PDEATHSIG, 9);
    prctl(PR_SET_TIMERSLACK, 1);
    const int fifo = sched_setscheduler(0, SCHED_FIFO, &priority) == 0;
    const int64_t spin = fifo ? atoll(argv[3]) : 0;
    int64_t(*wakes)[4] = calloc(count, sizeof *wakes);
    if (!wakes)
        return 1;
    for (int64_t i = 0; i < count; i++)
        wakes[i][0] = 1; /* so that every page is there */
    mlockall(MCL_CURRENT | MCL_FUTURE);

    int64_t due = now() + period;
    for (int64_t i = 0; i < count; i++, due += period) {
        int64_t t = now(), skipped = 0, slept;
        if (t > due + period) {
            skipped = (t - due) / period;
            due += skipped * period;
        }
        const int64_t until = due - spin;
        if (until > t) {
            const struct timespec wake = {until / 1000000000LL, until % 1000000000LL};
            clock_nanosleep(CLOCK_MONOTONIC, TIMER_ABSTIME, &wake, NULL);
        }
        t = slept = now();
        while (t < due)
            t = now();
        wakes[i][0] = t;
        wakes[i][1] = t - due;
        wakes[i][2] = slept - until;
        wakes[i][3] = skipped;
    }
    FILE *file = fopen(argv[5], "wb");
    if (!file || fwrite(wakes, sizeof *wakes, count, file) != (size_t)count || fclose(file))
        return 1;
    printf("%d\n", fifo);
    return 0;
}
