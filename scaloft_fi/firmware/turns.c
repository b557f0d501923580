// Loaded in front of the C library of a program (LD_PRELOAD): its threads run one at a time in a fixed order, its clock
// moves only as far as a simulator grants, and its network is one Unix socket.  So what the program does follows from
// the datagrams and the grants alone.  It knows no program by name, and changes nothing but the functions below.
//
// A thread runs until it would block: on a mutex, a condition, a semaphore, a join, a sleep, or a file descriptor.  Then
// the thread that has been ready the longest runs.  Where none is ready, the sleeper that is due first moves the clock.
// Where none is due before the end of the granted time, the library sends what the program sent since the last time,
// and waits for the next grant.  Both messages are little-endian, over a Unix socket of type SOCK_SEQPACKET:
//
//     u64 time: to the simulator the time so far, from it the time that is granted more [ns]
//     then for each datagram, in order: u16 port, u16 length, bytes
//
// Each reading of a clock moves it by a microsecond, so a program that waits for a time in a loop gets there.
#define _GNU_SOURCE
#include <dlfcn.h>
#include <errno.h>
#include <fcntl.h>
#include <netinet/in.h>
#include <poll.h>
#include <pthread.h>
#include <semaphore.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/select.h>
#include <sys/socket.h>
#include <sys/syscall.h>
#include <sys/time.h>
#include <sys/un.h>
#include <sys/wait.h>
#include <time.h>
#include <unistd.h>

#define REAL(name) ({ static __typeof__(&name) found; if (!found) found = (__typeof__(&name))dlsym(RTLD_NEXT, #name); found; })
#define NEVER INT64_MAX
enum { READING_NS = 1000, MOST = 1024, MOST_BYTES = 196608 };

struct thread {
  pthread_cond_t go;
  struct thread *next;
  const void *on;      // what it waits for; NULL for a time or descriptors alone
  struct pollfd *fds;  // the descriptors that it waits for
  nfds_t count;
  int64_t until;       // it waits no longer than this [ns]
  int woken, done;     // woken by what it waits for, not by the time
  void *(*start)(void *), *argument;
};

static pthread_mutex_t lock = PTHREAD_MUTEX_INITIALIZER;
static pthread_key_t ending;
static struct thread first = {.go = PTHREAD_COND_INITIALIZER}, *running, *ready, *waiting;  // queues, the oldest first
static __thread struct thread *self;
static struct { pthread_t id; struct thread *thread; } known[MOST];
static int64_t now_ns, granted_ns;
static struct sockaddr_un place = {.sun_family = AF_UNIX};
static int channel = -1;  // to the simulator, from the first exchange on
static struct {
  int peer;       // the other end of the pair that stands for a socket of the network; 0: none
  uint16_t port;  // its own port, or the one that it sends to
  int listens;
} sockets[MOST];
static char serving[MOST];   // of the connection of a child process: 1: it is there, 2: it has asked for something
static int children, asked;  // children that the program waits for; those of their connections that wait for it
static unsigned char outgoing[MOST_BYTES], incoming[MOST_BYTES];
static size_t sent = 8;

static int active(void) { return self != NULL; }
static int within(int fd) { return active() && fd >= 0 && fd < MOST; }
static int ours(int fd) { return within(fd) && sockets[fd].peer; }
static int serves(int fd) { return within(fd) && serving[fd]; }
static int64_t in_ns(const struct timespec *t) { return t->tv_sec * 1000000000LL + t->tv_nsec; }
static uint16_t port_of(const struct sockaddr *address) { return ntohs(((const struct sockaddr_in *)address)->sin_port); }

static void append(struct thread **queue, struct thread *one) {
  while (*queue) queue = &(*queue)->next;
  one->next = NULL;
  *queue = one;
}

static void make_ready(struct thread **place, int woken) {
  struct thread *one = *place;
  *place = one->next;
  one->woken = woken;
  append(&ready, one);
}

static int wake(const void *on, int most) {
  for (struct thread **place = &waiting; *place && most > 0;)
    if ((*place)->on == on) make_ready(place, 1), most--;
    else place = &(*place)->next;
  return 0;
}

static void deliver(uint16_t port, const unsigned char *bytes, size_t length) {
  int fd = -1, pair[2];
  for (int one = 0; one < MOST; one++)
    if (sockets[one].peer && sockets[one].port == port && (fd < 0 || !sockets[one].listens)) fd = one;
  if (fd >= 0 && sockets[fd].listens) {  // the first bytes open a connection, which `accept` finds
    if (REAL(write)(sockets[fd].peer, "", 1) != 1 || socketpair(AF_UNIX, SOCK_STREAM, 0, pair) || pair[1] >= MOST) return;
    fd = pair[0];
    sockets[fd].peer = pair[1], sockets[fd].port = port;
  }
  if (fd >= 0 && length) (void)!REAL(send)(sockets[fd].peer, bytes, length, MSG_DONTWAIT | MSG_NOSIGNAL);
}

static void reach(void) {
  int fd = REAL(socket)(AF_UNIX, SOCK_SEQPACKET | SOCK_CLOEXEC, 0);
  if (fd < 0 || REAL(connect)(fd, (struct sockaddr *)&place, sizeof place)) _exit(127);
  channel = fcntl(fd, F_DUPFD_CLOEXEC, MOST / 2);
  REAL(close)(fd);
}

static void exchange(void) {
  if (channel < 0) reach();
  now_ns = granted_ns;
  memcpy(outgoing, &now_ns, 8);
  if (REAL(send)(channel, outgoing, sent, MSG_NOSIGNAL) < 0) _exit(0);
  sent = 8;
  ssize_t length = REAL(recv)(channel, incoming, sizeof incoming, 0);
  if (length < 8) _exit(0);  // the simulator has gone
  granted_ns += *(uint64_t *)incoming;
  for (ssize_t at = 8; at + 4 <= length;) {
    uint16_t head[2];
    memcpy(head, incoming + at, 4);
    if (at + 4 + head[1] <= length) deliver(head[0], incoming + at + 4, head[1]);
    at += 4 + head[1];
  }
}

// Wait until a descriptor of a waiting thread is ready, however long that takes.
static void wait_outside(void) {
  struct pollfd all[MOST];
  nfds_t count = 0;
  for (struct thread *one = waiting; one; one = one->next)
    for (nfds_t i = 0; i < one->count && count < MOST; i++) all[count++] = one->fds[i];
  REAL(poll)(all, count, -1);
}

// Let the next thread run.  It is called with the lock held.
static void pass(void) {
  while (!ready) {
    struct thread **due = NULL;
    for (struct thread **place = &waiting; *place;) {
      if ((*place)->count && REAL(poll)((*place)->fds, (*place)->count, 0) > 0) {
        make_ready(place, 1);
        continue;
      }
      if ((*place)->until < granted_ns && (!due || (*place)->until < (*due)->until)) due = place;
      place = &(*place)->next;
    }
    if (ready) break;
    if (children && !asked) wait_outside();  // a child is at work, which takes no time
    else if (!due) exchange();
    else {
      if ((*due)->until > now_ns) now_ns = (*due)->until;
      make_ready(due, 0);
    }
  }
  running = ready;
  ready = ready->next;
  REAL(pthread_cond_signal)(&running->go);
}

// Wait for `on`, descriptors or a time; returns whether it was woken by anything but the time.
static int wait_for(const void *on, struct pollfd *fds, nfds_t count, int64_t until) {
  REAL(pthread_mutex_lock)(&lock);
  self->on = on, self->fds = fds, self->count = count, self->until = until;
  append(&waiting, self);
  pass();
  while (running != self) REAL(pthread_cond_wait)(&self->go, &lock);
  self->on = NULL, self->count = 0;
  REAL(pthread_mutex_unlock)(&lock);
  return self->woken;
}

static void *begin(void *given) {
  struct thread *one = given;
  REAL(pthread_mutex_lock)(&lock);
  while (running != one) REAL(pthread_cond_wait)(&one->go, &lock);
  REAL(pthread_mutex_unlock)(&lock);
  self = one;
  pthread_setspecific(ending, one);
  return one->start(one->argument);
}

static void end(void *given) {
  REAL(pthread_mutex_lock)(&lock);
  ((struct thread *)given)->done = 1;
  wake(given, MOST);
  self = NULL;
  pass();
  REAL(pthread_mutex_unlock)(&lock);
}

static void leave(void) { self = NULL; }  // a child that was forked is another program

__attribute__((constructor)) static void load(void) {
  char own[16], *known_pid = getenv("SCALOFT_TURNS_OF"), *path = getenv("SCALOFT_TURNS");
  sprintf(own, "%d", getpid());
  // what the program starts is another program; what replaces it, as a shell's `exec` does, is not
  if (!path || (known_pid && strcmp(known_pid, own))) return;
  strncpy(place.sun_path, path, sizeof place.sun_path - 1);
  setenv("SCALOFT_TURNS_OF", own, 1);
  pthread_key_create(&ending, end);
  pthread_atfork(NULL, NULL, leave);
  self = running = &first;
}

// The C library, as the program sees it: threads.

int pthread_create(pthread_t *id, const pthread_attr_t *attributes, void *(*start)(void *), void *argument) {
  if (!active()) return REAL(pthread_create)(id, attributes, start, argument);
  struct thread *one = calloc(1, sizeof *one);
  pthread_attr_t plain;  // a thread with a priority in real time would need a right that few have
  size_t size;
  pthread_attr_init(&plain);
  if (attributes && !pthread_attr_getstacksize(attributes, &size)) pthread_attr_setstacksize(&plain, size);
  pthread_cond_init(&one->go, NULL);
  one->start = start, one->argument = argument;
  int failed = REAL(pthread_create)(id, &plain, begin, one), at = 0;
  if (failed) return failed;
  while (at < MOST - 1 && known[at].thread && !pthread_equal(known[at].id, *id)) at++;
  known[at].id = *id, known[at].thread = one;
  append(&ready, one);
  return 0;
}

int pthread_join(pthread_t id, void **result) {
  for (int i = 0; active() && i < MOST; i++)
    if (known[i].thread && pthread_equal(known[i].id, id))
      while (!known[i].thread->done) wait_for(known[i].thread, NULL, 0, NEVER);
  return REAL(pthread_join)(id, result);
}

int pthread_mutex_lock(pthread_mutex_t *mutex) {
  if (!active()) return REAL(pthread_mutex_lock)(mutex);
  int failed;
  while ((failed = pthread_mutex_trylock(mutex)) == EBUSY) wait_for(mutex, NULL, 0, NEVER);
  return failed;
}

int pthread_mutex_unlock(pthread_mutex_t *mutex) {
  int failed = REAL(pthread_mutex_unlock)(mutex);
  return active() && !failed ? wake(mutex, 1) : failed;
}

static int wait_on(pthread_cond_t *condition, pthread_mutex_t *mutex, int64_t until) {
  pthread_mutex_unlock(mutex);
  int woken = wait_for(condition, NULL, 0, until);
  pthread_mutex_lock(mutex);
  return woken ? 0 : ETIMEDOUT;
}

int pthread_cond_wait(pthread_cond_t *condition, pthread_mutex_t *mutex) {
  return active() ? wait_on(condition, mutex, NEVER) : REAL(pthread_cond_wait)(condition, mutex);
}

int pthread_cond_timedwait(pthread_cond_t *condition, pthread_mutex_t *mutex, const struct timespec *until) {
  return active() ? wait_on(condition, mutex, in_ns(until)) : REAL(pthread_cond_timedwait)(condition, mutex, until);
}

int pthread_cond_clockwait(pthread_cond_t *on, pthread_mutex_t *mutex, clockid_t clock, const struct timespec *until) {
  return active() ? wait_on(on, mutex, in_ns(until)) : REAL(pthread_cond_clockwait)(on, mutex, clock, until);
}

int pthread_cond_signal(pthread_cond_t *on) { return active() ? wake(on, 1) : REAL(pthread_cond_signal)(on); }
int pthread_cond_broadcast(pthread_cond_t *on) { return active() ? wake(on, MOST) : REAL(pthread_cond_broadcast)(on); }

int sem_post(sem_t *semaphore) {
  int failed = REAL(sem_post)(semaphore);
  return active() && !failed ? wake(semaphore, 1) : failed;
}

int sem_timedwait(sem_t *semaphore, const struct timespec *until) {
  if (!active()) return REAL(sem_timedwait)(semaphore, until);
  while (sem_trywait(semaphore))
    if (!wait_for(semaphore, NULL, 0, in_ns(until))) return errno = ETIMEDOUT, -1;
  return 0;
}

int sem_wait(sem_t *semaphore) {
  return active() ? sem_timedwait(semaphore, &(struct timespec){INT32_MAX, 0}) : REAL(sem_wait)(semaphore);
}

int pthread_setschedparam(pthread_t id, int policy, const struct sched_param *parameters) {
  return active() ? 0 : REAL(pthread_setschedparam)(id, policy, parameters);
}

// Children: while one is at work the clock stands, unless the child waits for the program.

int system(const char *command) {
  if (!active() || !command) return REAL(system)(command);
  pid_t child = fork();
  if (!child) execl("/bin/sh", "sh", "-c", command, NULL), _exit(127);
  struct pollfd end = {.fd = syscall(SYS_pidfd_open, child, 0), .events = POLLIN};
  int status = -1;
  children++;
  if (end.fd >= 0) poll(&end, 1, -1);
  children--;
  waitpid(child, &status, 0);
  REAL(close)(end.fd);
  return status;
}

// The clock.

int clock_gettime(clockid_t clock, struct timespec *t) {
  if (!active() || clock == CLOCK_PROCESS_CPUTIME_ID || clock == CLOCK_THREAD_CPUTIME_ID)
    return REAL(clock_gettime)(clock, t);
  now_ns += READING_NS;
  if (now_ns >= granted_ns) wait_for(NULL, NULL, 0, now_ns);
  t->tv_sec = now_ns / 1000000000, t->tv_nsec = now_ns % 1000000000;
  return 0;
}

int gettimeofday(struct timeval *t, void *zone) {
  struct timespec now;
  if (!active()) return REAL(gettimeofday)(t, zone);
  clock_gettime(CLOCK_REALTIME, &now);
  t->tv_sec = now.tv_sec, t->tv_usec = now.tv_nsec / 1000;
  return 0;
}

time_t time(time_t *given) {
  struct timespec now;
  clock_gettime(CLOCK_REALTIME, &now);
  if (given) *given = now.tv_sec;
  return now.tv_sec;
}

int clock_nanosleep(clockid_t clock, int flags, const struct timespec *asked, struct timespec *left) {
  if (!active()) return REAL(clock_nanosleep)(clock, flags, asked, left);
  wait_for(NULL, NULL, 0, in_ns(asked) + (flags & TIMER_ABSTIME ? 0 : now_ns));
  return 0;
}

int nanosleep(const struct timespec *asked, struct timespec *left) {
  return active() ? clock_nanosleep(CLOCK_MONOTONIC, 0, asked, left) : REAL(nanosleep)(asked, left);
}

int usleep(useconds_t us) { return nanosleep(&(struct timespec){us / 1000000, us % 1000000 * 1000L}, NULL); }
unsigned sleep(unsigned s) { return nanosleep(&(struct timespec){s, 0}, NULL), 0; }
int sched_yield(void) { return active() ? usleep(1) : REAL(sched_yield)(); }

// The network: each socket is one end of a pair, whose other end the library holds.

int poll(struct pollfd *fds, nfds_t count, int timeout_ms) {
  if (!active()) return REAL(poll)(fds, count, timeout_ms);
  int64_t until = timeout_ms < 0 ? NEVER : now_ns + timeout_ms * 1000000LL;
  for (;;) {
    int found = REAL(poll)(fds, count, 0);
    if (found || !timeout_ms || !wait_for(NULL, fds, count, until)) return found;
  }
}

int select(int most, fd_set *reads, fd_set *writes, fd_set *errors, struct timeval *timeout) {
  if (!active()) return REAL(select)(most, reads, writes, errors, timeout);
  struct pollfd fds[MOST];
  nfds_t count = 0;
  int found = 0;
  for (int fd = 0; fd < most && fd < MOST; fd++) {
    short events = (reads && FD_ISSET(fd, reads) ? POLLIN : 0) | (writes && FD_ISSET(fd, writes) ? POLLOUT : 0);
    if (events) fds[count++] = (struct pollfd){.fd = fd, .events = events};
  }
  poll(fds, count, timeout ? timeout->tv_sec * 1000 + (timeout->tv_usec + 999) / 1000 : -1);
  if (reads) FD_ZERO(reads);
  if (writes) FD_ZERO(writes);
  if (errors) FD_ZERO(errors);
  for (nfds_t i = 0; i < count; i++) {
    if (fds[i].events & POLLIN && fds[i].revents & ~POLLOUT) FD_SET(fds[i].fd, reads), found++;
    if (fds[i].revents & POLLOUT) FD_SET(fds[i].fd, writes), found++;
  }
  return found;
}

int socket(int domain, int type, int protocol) {
  int pair[2], bytes = MOST_BYTES;
  if (!active() || domain != AF_INET) return REAL(socket)(domain, type, protocol);
  if (socketpair(AF_UNIX, type, 0, pair) || pair[1] >= MOST) return errno = EMFILE, -1;
  setsockopt(pair[1], SOL_SOCKET, SO_SNDBUF, &bytes, sizeof bytes);
  sockets[pair[0]].peer = pair[1];
  return pair[0];
}

int bind(int fd, const struct sockaddr *address, socklen_t length) {
  return ours(fd) ? sockets[fd].port = port_of(address), 0 : REAL(bind)(fd, address, length);
}

int connect(int fd, const struct sockaddr *address, socklen_t length) {
  return ours(fd) ? bind(fd, address, length) : REAL(connect)(fd, address, length);
}

int listen(int fd, int most) { return ours(fd) ? sockets[fd].listens = 1, 0 : REAL(listen)(fd, most); }

int setsockopt(int fd, int level, int name, const void *value, socklen_t length) {
  return ours(fd) ? 0 : REAL(setsockopt)(fd, level, name, value, length);
}

static void wait_readable(int fd, int flags) {
  struct pollfd one = {.fd = fd, .events = POLLIN};
  if (active() && !(flags & MSG_DONTWAIT) && !(fcntl(fd, F_GETFL) & O_NONBLOCK)) poll(&one, 1, -1);
}

static void tell(int fd, struct sockaddr *address, socklen_t *length) {
  struct sockaddr_in from = {AF_INET, htons(sockets[fd].port), {htonl(INADDR_LOOPBACK)}, {0}};
  if (address && length) memcpy(address, &from, *length < sizeof from ? *length : sizeof from), *length = sizeof from;
}

int accept4(int fd, struct sockaddr *address, socklen_t *length, int flags) {
  char byte;
  wait_readable(fd, 0);
  if (!ours(fd)) {
    int made = REAL(accept4)(fd, address, length, flags);
    if (within(made)) serving[made] = 1;
    return made;
  }
  if (REAL(read)(fd, &byte, 1) == 1)
    for (int one = 0; one < MOST; one++)
      if (one != fd && sockets[one].peer && sockets[one].port == sockets[fd].port) {
        if (flags & SOCK_NONBLOCK) fcntl(one, F_SETFL, O_NONBLOCK);
        return tell(one, address, length), one;
      }
  return errno = EAGAIN, -1;
}

int accept(int fd, struct sockaddr *address, socklen_t *length) { return accept4(fd, address, length, 0); }

static ssize_t put(int fd, const void *bytes, size_t length, const struct sockaddr *to) {
  if (to && !sockets[fd].port) sockets[fd].port = port_of(to);  // whoever answers sends it there
  uint16_t head[2] = {to ? port_of(to) : sockets[fd].port, (uint16_t)length};
  if (length > UINT16_MAX || sent + 4 + length > MOST_BYTES) return length;  // lost, as datagrams are
  memcpy(outgoing + sent, head, 4);
  memcpy(outgoing + sent + 4, bytes, length);
  sent += 4 + length;
  return length;
}

ssize_t sendto(int fd, const void *bytes, size_t length, int flags, const struct sockaddr *to, socklen_t size) {
  return ours(fd) ? put(fd, bytes, length, to) : REAL(sendto)(fd, bytes, length, flags, to, size);
}

ssize_t send(int fd, const void *bytes, size_t length, int flags) { return sendto(fd, bytes, length, flags, NULL, 0); }

ssize_t write(int fd, const void *bytes, size_t length) {
  return ours(fd) ? put(fd, bytes, length, NULL) : REAL(write)(fd, bytes, length);
}

ssize_t recvfrom(int fd, void *bytes, size_t length, int flags, struct sockaddr *from, socklen_t *size) {
  wait_readable(fd, flags);
  if (!ours(fd)) return REAL(recvfrom)(fd, bytes, length, flags, from, size);
  tell(fd, from, size);
  return REAL(recv)(fd, bytes, length, flags);
}

ssize_t recv(int fd, void *bytes, size_t length, int flags) { return recvfrom(fd, bytes, length, flags, NULL, NULL); }

ssize_t read(int fd, void *bytes, size_t length) {
  if (ours(fd) || serves(fd)) wait_readable(fd, 0);
  ssize_t got = REAL(read)(fd, bytes, length);
  if (serves(fd) && serving[fd] == 1 && got > 0) serving[fd] = 2, asked++;
  return got;
}

static void served(int fd) {
  if (serves(fd)) asked -= serving[fd] == 2, serving[fd] = 0;
}

int shutdown(int fd, int how) { return served(fd), REAL(shutdown)(fd, how); }

int close(int fd) {
  served(fd);
  if (ours(fd)) REAL(close)(sockets[fd].peer), memset(&sockets[fd], 0, sizeof sockets[fd]);
  return REAL(close)(fd);
}
