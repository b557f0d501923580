// Loaded in front of the C library of a program (LD_PRELOAD): its threads run one at a time in a fixed order, its clock
// moves only as far as a simulator grants, and its network is one Unix socket.  So what the program does follows from
// the datagrams and the grants alone.  It knows no program by name, and changes nothing but the functions below.
//
// A thread runs until it would block: on a mutex, a condition, a semaphore, a join, a sleep or a file descriptor.  Then
// the thread that has been ready the longest runs.  Where none is ready, the sleeper that is due first moves the clock.
// Where none is due before the end of the granted time, the library sends what the program sent since the last time,
// and waits for the next grant.  Both messages are little-endian, over a Unix socket of type SOCK_SEQPACKET:
//
//     u64 time: to the simulator the time so far, from it the time that is granted more [ns]
//     then for each datagram, in order: u16 port, u16 length, bytes
//
// Each reading of a clock moves it by a microsecond, so a program that waits for a time in a loop gets there.
#define _GNU_SOURCE
#include <arpa/inet.h>
#include <dlfcn.h>
#include <errno.h>
#include <fcntl.h>
#include <poll.h>
#include <pthread.h>
#include <semaphore.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>
#include <sys/queue.h>
#include <sys/syscall.h>
#include <sys/time.h>
#include <sys/un.h>
#include <sys/wait.h>
#include <unistd.h>

// A function of the C library itself.
#define REAL(name) ({ static __typeof__(&name) found; found ? found : (found = dlsym(RTLD_NEXT, #name)); })

// A function as the program sees it: the value for a thread that takes turns, or for a socket of the network; else the
// C library's own.
#define TURN(name, parameters, arguments, value) int name parameters { return self ? value : REAL(name) arguments; }
#define SOCKET(type, name, parameters, arguments, value) \
  type name parameters { return ours(fd) ? value : REAL(name) arguments; }

enum { READING_NS = 1000, MOST = 1024, MOST_BYTES = 196608 };

struct thread {
  sem_t go, ended;
  TAILQ_ENTRY(thread) place;  // in `ready` or `waiting`, the oldest first
  const void *on;             // what it waits for; NULL for a time or descriptors alone
  struct pollfd *fds;         // the descriptors that it waits for
  nfds_t count;
  int64_t until;              // it waits no longer than this [ns]
  int woken;                  // by what it waits for, not by the time
  void *(*start)(void *), *argument;
  pthread_t id;
  struct thread *older;       // the one that was created before
};

static struct thread first, *newest;
static __thread struct thread *self;  // NULL: it takes no turns
static TAILQ_HEAD(, thread) ready = TAILQ_HEAD_INITIALIZER(ready), waiting = TAILQ_HEAD_INITIALIZER(waiting);
static pthread_key_t ending;
static int64_t now_ns, granted_ns;
struct __attribute__((packed)) datagram { uint16_t port, length; char bytes[]; };
static int64_t outgoing[1 + MOST_BYTES / 8], incoming[1 + MOST_BYTES / 8];  // a time [ns], then datagrams
static size_t sent = 8;                                                    // length of `outgoing` so far
static struct {
  int peer;             // the other end of the pair that stands for a socket of the network; 0: none
  uint16_t port;        // its own port, or the one that it sends to
  int listens, serves;  // serves: 1: it is the connection of a child process, 2: the child has asked for something
} sockets[MOST];
static int children, asked;  // children that the program waits for; those of their connections that wait for it

static int within(int fd) { return self && fd >= 0 && fd < MOST; }
static int ours(int fd) { return within(fd) && sockets[fd].peer; }
static int serves(int fd) { return within(fd) ? sockets[fd].serves : 0; }
static int64_t in_ns(const struct timespec *t) { return t->tv_sec * 1000000000LL + t->tv_nsec; }
static uint16_t port_of(const struct sockaddr *given) { return ntohs(((const struct sockaddr_in *)given)->sin_port); }

// Each waiting thread, the oldest first; it may be made ready meanwhile.
#define EACH_WAITING(one) \
  for (struct thread *one = TAILQ_FIRST(&waiting), *next; one && (next = TAILQ_NEXT(one, place), 1); one = next)

static void make_ready(struct thread *one, int woken) {
  TAILQ_REMOVE(&waiting, one, place);
  TAILQ_INSERT_TAIL(&ready, one, place);
  one->woken = woken;
}

static void wake(const void *on, int most) {
  if (!self) return;
  EACH_WAITING(one)
    if (one->on == on && most-- > 0) make_ready(one, 1);
}

static int open_pair(int type, uint16_t port) {
  int pair[2], bytes = MOST_BYTES;
  if (socketpair(AF_UNIX, type, 0, pair) || pair[1] >= MOST) return errno = EMFILE, -1;
  REAL(setsockopt)(pair[1], SOL_SOCKET, SO_SNDBUF, &bytes, sizeof bytes);
  sockets[pair[0]].peer = pair[1], sockets[pair[0]].port = port;
  return pair[0];
}

static void deliver(const struct datagram *one) {
  int fd = -1, listener;
  for (int i = 0; i < MOST; i++)
    if (sockets[i].peer && sockets[i].port == one->port && (fd < 0 || !sockets[i].listens)) fd = i;
  if (fd >= 0 && sockets[fd].listens) {  // the first bytes open a connection, which `accept` finds
    listener = sockets[fd].peer;
    fd = open_pair(SOCK_STREAM, one->port);
    (void)!REAL(write)(listener, &fd, sizeof fd);
  }
  if (fd >= 0 && one->length) REAL(send)(sockets[fd].peer, one->bytes, one->length, MSG_DONTWAIT | MSG_NOSIGNAL);
}

static void exchange(void) {
  static int channel = -1;
  if (channel < 0) {
    struct sockaddr_un simulator = {.sun_family = AF_UNIX};
    strncpy(simulator.sun_path, getenv("SCALOFT_TURNS"), sizeof simulator.sun_path - 1);
    channel = REAL(socket)(AF_UNIX, SOCK_SEQPACKET | SOCK_CLOEXEC, 0);
    if (REAL(connect)(channel, (struct sockaddr *)&simulator, sizeof simulator)) _exit(127);
  }
  outgoing[0] = now_ns = granted_ns;
  REAL(send)(channel, outgoing, sent, MSG_NOSIGNAL);
  sent = 8;
  ssize_t length = REAL(recv)(channel, incoming, sizeof incoming, MSG_TRUNC);
  if (length < 8 || length > (ssize_t)sizeof incoming) _exit(0);  // the simulator has gone
  granted_ns += incoming[0];
  struct datagram *one = (void *)(incoming + 1), *end = (void *)((char *)incoming + length);
  for (; one < end; one = (void *)(one->bytes + one->length)) deliver(one);
}

// Let the next thread run.
static void pass(void) {
  struct thread *chosen;
  while (!(chosen = TAILQ_FIRST(&ready))) {
    struct thread *due = NULL;
    EACH_WAITING(one)
      if (one->count && REAL(poll)(one->fds, one->count, 0) > 0) make_ready(one, 1);
      else if (one->until < granted_ns && (!due || one->until < due->until)) due = one;
    if (!TAILQ_EMPTY(&ready)) continue;
    if (children && !asked) REAL(usleep)(100);  // a child is at work, which takes no time
    else if (due) make_ready(due, 0);
    else exchange();
  }
  TAILQ_REMOVE(&ready, chosen, place);
  REAL(sem_post)(&chosen->go);
}

// Wait for `on`, descriptors or a time; returns whether it was woken by anything but the time.
static int wait_for(const void *on, struct pollfd *fds, nfds_t count, int64_t until) {
  self->on = on, self->fds = fds, self->count = count, self->until = until;
  TAILQ_INSERT_TAIL(&waiting, self, place);
  pass();
  while (REAL(sem_wait)(&self->go)) continue;
  if (!self->woken && self->until > now_ns) now_ns = self->until;
  return self->woken;
}

static void *begin(void *given) {
  self = given;
  while (REAL(sem_wait)(&self->go)) continue;
  pthread_setspecific(ending, self);
  return self->start(self->argument);
}

static void end(void *given) {
  sem_post(&self->ended);
  self = NULL;
  pass();
}

static void leave(void) { self = NULL; }  // a child that was forked is another program

__attribute__((constructor)) static void load(void) {
  // what the program starts is another program; what replaces it, as a shell's `exec` does, leads its session still
  if (!getenv("SCALOFT_TURNS") || getsid(0) != getpid()) return;
  pthread_key_create(&ending, end);
  pthread_atfork(NULL, NULL, leave);
  self = &first;
}

// Threads.

int pthread_create(pthread_t *id, const pthread_attr_t *attributes, void *(*start)(void *), void *argument) {
  if (!self) return REAL(pthread_create)(id, attributes, start, argument);
  // a thread with a priority in real time would need a right that few have
  if (attributes) pthread_attr_setinheritsched((pthread_attr_t *)attributes, PTHREAD_INHERIT_SCHED);
  struct thread *one = calloc(1, sizeof *one);
  one->start = start, one->argument = argument;
  int failed = REAL(pthread_create)(id, attributes, begin, one);
  if (failed) return failed;
  one->id = *id, one->older = newest, newest = one;
  TAILQ_INSERT_TAIL(&ready, one, place);
  return 0;
}

int pthread_join(pthread_t id, void **result) {
  struct thread *one = self ? newest : NULL;
  while (one && !pthread_equal(one->id, id)) one = one->older;
  if (one) sem_wait(&one->ended);
  return REAL(pthread_join)(id, result);
}

TURN(pthread_setschedparam, (pthread_t id, int policy, const struct sched_param *to), (id, policy, to), 0)

int pthread_mutex_lock(pthread_mutex_t *mutex) {
  if (!self) return REAL(pthread_mutex_lock)(mutex);
  int failed;
  while ((failed = pthread_mutex_trylock(mutex)) == EBUSY) wait_for(mutex, NULL, 0, INT64_MAX);
  return failed;
}

#define WAKING(name, type, most) int name(type *on) { return wake(on, most), REAL(name)(on); }
WAKING(pthread_mutex_unlock, pthread_mutex_t, 1)
WAKING(pthread_cond_signal, pthread_cond_t, 1)
WAKING(pthread_cond_broadcast, pthread_cond_t, MOST)
WAKING(sem_post, sem_t, 1)

static int wait_on(pthread_cond_t *condition, pthread_mutex_t *mutex, int64_t until) {
  pthread_mutex_unlock(mutex);
  int woken = wait_for(condition, NULL, 0, until);
  pthread_mutex_lock(mutex);
  return woken ? 0 : ETIMEDOUT;
}

TURN(pthread_cond_wait, (pthread_cond_t *on, pthread_mutex_t *mutex), (on, mutex), wait_on(on, mutex, INT64_MAX))

TURN(pthread_cond_timedwait, (pthread_cond_t *on, pthread_mutex_t *mutex, const struct timespec *until),
     (on, mutex, until), wait_on(on, mutex, in_ns(until)))

TURN(pthread_cond_clockwait, (pthread_cond_t *on, pthread_mutex_t *mutex, clockid_t clock, const struct timespec *end),
     (on, mutex, clock, end), wait_on(on, mutex, in_ns(end)))

int sem_timedwait(sem_t *semaphore, const struct timespec *until) {
  if (!self) return REAL(sem_timedwait)(semaphore, until);
  while (sem_trywait(semaphore))
    if (!wait_for(semaphore, NULL, 0, in_ns(until))) return errno = ETIMEDOUT, -1;
  return 0;
}

TURN(sem_wait, (sem_t *one), (one), sem_timedwait(one, &(struct timespec){INT32_MAX, 0}))

// The clock.

static int sleep_until(int64_t ns) { return wait_for(NULL, NULL, 0, ns); }

int clock_gettime(clockid_t clock, struct timespec *t) {
  if (!self) return REAL(clock_gettime)(clock, t);
  now_ns += READING_NS;
  if (now_ns >= granted_ns) sleep_until(now_ns);
  *t = (struct timespec){now_ns / 1000000000, now_ns % 1000000000};
  return 0;
}

int gettimeofday(struct timeval *t, void *zone) {
  struct timespec now;
  clock_gettime(CLOCK_REALTIME, &now);
  TIMESPEC_TO_TIMEVAL(t, &now);
  return 0;
}

time_t time(time_t *given) {
  struct timeval now;
  gettimeofday(&now, NULL);
  return given ? *given = now.tv_sec : now.tv_sec;
}

TURN(clock_nanosleep, (clockid_t clock, int flags, const struct timespec *t, struct timespec *left),
     (clock, flags, t, left), sleep_until(in_ns(t) + (flags & TIMER_ABSTIME ? 0 : now_ns)))

TURN(nanosleep, (const struct timespec *t, struct timespec *left), (t, left), sleep_until(now_ns + in_ns(t)))
int usleep(useconds_t us) { return nanosleep(&(struct timespec){us / 1000000, us % 1000000 * 1000L}, NULL); }
unsigned sleep(unsigned s) { return nanosleep(&(struct timespec){s, 0}, NULL), 0; }
TURN(sched_yield, (void), (), usleep(1))

// The network: each socket is one end of a pair, whose other end the library holds.

int poll(struct pollfd *fds, nfds_t count, int timeout_ms) {
  if (!self) return REAL(poll)(fds, count, timeout_ms);
  int64_t until = timeout_ms < 0 ? INT64_MAX : now_ns + timeout_ms * 1000000LL;
  int found;
  while (!(found = REAL(poll)(fds, count, 0)) && timeout_ms && wait_for(NULL, fds, count, until)) continue;
  return found;
}

int select(int most, fd_set *reads, fd_set *writes, fd_set *errors, struct timeval *timeout) {
  if (!self) return REAL(select)(most, reads, writes, errors, timeout);
  struct pollfd fds[MOST], *next = fds;
  for (int fd = 0; fd < most && fd < MOST; fd++) {
    short events = (reads && FD_ISSET(fd, reads) ? POLLIN : 0) | (writes && FD_ISSET(fd, writes) ? POLLOUT : 0);
    if (events) *next++ = (struct pollfd){.fd = fd, .events = events};
  }
  poll(fds, next - fds, timeout ? timeout->tv_sec * 1000 + (timeout->tv_usec + 999) / 1000 : -1);
  return REAL(select)(most, reads, writes, errors, &(struct timeval){0, 0});
}

int socket(int domain, int type, int protocol) {
  return self && domain == AF_INET ? open_pair(type, 0) : REAL(socket)(domain, type, protocol);
}

SOCKET(int, bind, (int fd, const struct sockaddr *at, socklen_t n), (fd, at, n), (sockets[fd].port = port_of(at), 0))

SOCKET(int, connect, (int fd, const struct sockaddr *to, socklen_t n), (fd, to, n), bind(fd, to, n))

SOCKET(int, listen, (int fd, int most), (fd, most), (sockets[fd].listens = 1, 0))

SOCKET(int, setsockopt, (int fd, int level, int name, const void *value, socklen_t n), (fd, level, name, value, n), 0)

static void wait_readable(int fd, int flags) {
  struct pollfd one = {.fd = fd, .events = POLLIN};
  if (self && !(flags & MSG_DONTWAIT) && !(fcntl(fd, F_GETFL) & O_NONBLOCK)) poll(&one, 1, -1);
}

static void tell(int fd, struct sockaddr *address, socklen_t *length) {
  struct sockaddr_in from = {AF_INET, htons(sockets[fd].port), {htonl(INADDR_LOOPBACK)}, {0}};
  if (address && length) memcpy(address, &from, *length < sizeof from ? *length : sizeof from), *length = sizeof from;
}

int accept4(int fd, struct sockaddr *address, socklen_t *length, int flags) {
  int made = -1;
  wait_readable(fd, 0);
  if (!ours(fd)) made = REAL(accept4)(fd, address, length, flags);
  else if (REAL(read)(fd, &made, sizeof made) > 0) tell(made, address, length);
  if (ours(made) && flags & SOCK_NONBLOCK) fcntl(made, F_SETFL, O_NONBLOCK);
  if (within(made)) sockets[made].serves = !ours(made);
  return made;
}

int accept(int fd, struct sockaddr *address, socklen_t *length) { return accept4(fd, address, length, 0); }

ssize_t sendto(int fd, const void *bytes, size_t length, int flags, const struct sockaddr *to, socklen_t n) {
  if (!ours(fd)) return REAL(sendto)(fd, bytes, length, flags, to, n);
  struct datagram *one = (void *)((char *)outgoing + sent);
  if (to && !sockets[fd].port) sockets[fd].port = port_of(to);  // whoever answers sends it there
  if (length > UINT16_MAX || sent + sizeof *one + length > sizeof outgoing) return length;  // lost, as datagrams are
  one->port = to ? port_of(to) : sockets[fd].port, one->length = length;
  memcpy(one->bytes, bytes, length);
  sent += sizeof *one + length;
  return length;
}

ssize_t send(int fd, const void *bytes, size_t length, int flags) { return sendto(fd, bytes, length, flags, NULL, 0); }

SOCKET(ssize_t, write, (int fd, const void *bytes, size_t size), (fd, bytes, size), send(fd, bytes, size, 0))

ssize_t recvfrom(int fd, void *bytes, size_t length, int flags, struct sockaddr *from, socklen_t *size) {
  wait_readable(fd, flags);
  if (ours(fd)) return tell(fd, from, size), REAL(recv)(fd, bytes, length, flags);
  return REAL(recvfrom)(fd, bytes, length, flags, from, size);
}

ssize_t recv(int fd, void *bytes, size_t length, int flags) { return recvfrom(fd, bytes, length, flags, NULL, NULL); }

ssize_t read(int fd, void *bytes, size_t length) {
  if (ours(fd) || serves(fd)) wait_readable(fd, 0);
  ssize_t got = REAL(read)(fd, bytes, length);
  if (serves(fd) == 1 && got > 0) sockets[fd].serves = 2, asked++;
  return got;
}

static void served(int fd) {
  if (serves(fd)) asked -= serves(fd) == 2, sockets[fd].serves = 0;
}

int shutdown(int fd, int how) { return served(fd), REAL(shutdown)(fd, how); }

int close(int fd) {
  served(fd);
  if (ours(fd)) REAL(close)(sockets[fd].peer), memset(&sockets[fd], 0, sizeof sockets[fd]);
  return REAL(close)(fd);
}

// Children: while one is at work the clock stands, unless the child waits for the program.

int system(const char *command) {
  if (!self) return REAL(system)(command);
  pid_t child = fork();
  if (!child) execl("/bin/sh", "sh", "-c", command, NULL), _exit(127);
  int status = -1, end = syscall(SYS_pidfd_open, child, 0);
  children++;
  wait_readable(end, 0);
  children--;
  waitpid(child, &status, 0);
  REAL(close)(end);
  return status;
}
