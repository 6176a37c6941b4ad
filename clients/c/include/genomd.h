/*
 * A daemon as a part of a program in C or C++, such as a plugin of a simulator: the program steps its
 * clock, and shares the memory of ports with it.
 *
 *     const char *arguments[] = { "arm.so", NULL };
 *     struct genomd *daemon = genomd_start(NULL, arguments);
 *     struct genomd_port *goal = genomd_in(daemon, "arm/goal", sizeof(double));
 *     struct genomd_port *torque = genomd_out(daemon, "arm/torque", sizeof(double));
 *     double *set = genomd_in_data(goal);
 *     const double *got = genomd_data(torque);
 *     for (int i = 0; i < 1000; i++) {
 *       *set = 0.5;
 *       genomd_write(goal);
 *       if (genomd_step(daemon, 1000000, NULL)) { fputs(genomd_error(), stderr); break; }
 *       apply(*got);
 *     }
 *     genomd_close(goal); genomd_close(torque); genomd_stop(daemon);
 *
 * Types of ports are those that `genomctl header arm.gen` prints. Functions that return int return 0,
 * or -1; those that return a pointer return NULL where they fail: genomd_error() says why. One thread
 * at a time may use a daemon and its ports.
 */
#ifndef H_GENOMD
#define H_GENOMD

#include <stddef.h>
#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

struct genomd;
struct genomd_port;

/*
 * Starts a daemon, with a virtual clock at 0, and returns when it is ready. `program` is genomd, or
 * NULL for $GENOMD or the one on PATH. `arguments`, which NULL ends, are components to load, and options
 * of its command line; NULL for none. Without --config nothing of it reaches other daemons on this
 * machine.
 */
struct genomd *genomd_start(const char *program, const char *const *arguments);

/* Stops it, and waits for its end. Ports that are still open keep their memory. NULL is allowed. */
void genomd_stop(struct genomd *daemon);

/* The Unix socket of its control plane, for all else: `genomctl --socket SOCKET call arm track`. */
const char *genomd_socket(const struct genomd *daemon);

/* The file that it logs to, which is removed when it is stopped. */
const char *genomd_log(const struct genomd *daemon);

/*
 * Advances the clock by so many nanoseconds, at most an hour, and runs all that is due; sets `now` to
 * its new time, unless that is NULL. Values that were written are published first; if one is refused,
 * time stays. A codel that does not return is waited for.
 */
int genomd_step(struct genomd *daemon, uint64_t nanoseconds, uint64_t *now);

/*
 * Shares an in port, "component/port", which this program writes, or an out port. `size` is that of
 * its type, as the compiler knows it: another one is refused. The type has to be of one size, without
 * unbounded strings or sequences. The component may be in a cell, and begin again in another process.
 */
struct genomd_port *genomd_in(struct genomd *daemon, const char *address, size_t size);
struct genomd_port *genomd_out(struct genomd *daemon, const char *address, size_t size);

/* Ends sharing: pointers to its value are not valid any more. NULL is allowed. */
void genomd_close(struct genomd_port *port);

/*
 * The value: of an in port what the next genomd_write() publishes, of an out port what codels wrote
 * last, as of the last step. It stays where it is as long as the port is open.
 */
const void *genomd_data(const struct genomd_port *port);

/* The same, to be changed; NULL for an out port. */
void *genomd_in_data(struct genomd_port *port);

/* How often it was written: by codels, as of the last step, or by this program. */
uint64_t genomd_count(const struct genomd_port *port);

/* Has the next step publish the value of an in port, before anything runs. It is checked then. */
int genomd_write(struct genomd_port *port);

/* 0 as long as the component is there, with a port of the same type. Looked at by each step. */
int genomd_check(const struct genomd_port *port);

/* Why the last function that failed in this thread did so; valid until the next one fails. */
const char *genomd_error(void);

#ifdef __cplusplus
}
#endif

#endif
