// Waits for a time in a loop, sends a datagram each 10 ms, and answers each datagram that comes.
#include <arpa/inet.h>
#include <fcntl.h>
#include <stdio.h>
#include <string.h>
#include <sys/socket.h>
#include <time.h>
#include <unistd.h>
static double now(void) {
  struct timespec t;
  clock_gettime(CLOCK_MONOTONIC, &t);
  return t.tv_sec + 1e-9 * t.tv_nsec;
}
int main(void) {
  int in = socket(AF_INET, SOCK_DGRAM, 0), out = socket(AF_INET, SOCK_DGRAM, 0);
  struct sockaddr_in here = {.sin_family = AF_INET, .sin_port = htons(4001)}, there = here;
  there.sin_port = htons(4002), there.sin_addr.s_addr = inet_addr("127.0.0.1");
  fcntl(in, F_SETFL, O_NONBLOCK);
  bind(in, (struct sockaddr *)&here, sizeof here);
  for (double next = now() + 0.01; next < 10.0; next += 0.01) {
    char text[64], heard[64] = "";
    while (now() < next) usleep(50);
    ssize_t length = recv(in, heard, sizeof heard - 1, 0);
    int size = snprintf(text, sizeof text, "%.6f %s", now(), length > 0 ? heard : "-");
    sendto(out, text, size, 0, (struct sockaddr *)&there, sizeof there);
  }
  return 3;
}
