# The program on Debian, with Mesa's software driver; with a GPU of NVIDIA where its container toolkit is. docs/ci.md says how to run it.
FROM rust:1-slim-bookworm AS build
WORKDIR /src
COPY . .
# The image has one toolchain: the file would have rustup download another.
RUN rm rust-toolchain.toml && cargo build --release --locked

FROM debian:bookworm-slim
# GLVND (libgl1, libegl1) is what NVIDIA's Vulkan driver loads, and the toolkit does not bring it.
RUN apt-get update -qq && \
    DEBIAN_FRONTEND=noninteractive apt-get install -y --no-install-recommends libvulkan1 mesa-vulkan-drivers libgl1 libegl1 && \
    rm -rf /var/lib/apt/lists/*
COPY --from=build /src/target/release/gpu-rt /usr/local/bin/
# By default the toolkit brings CUDA alone, and no Vulkan. NODEVICE_SELECT: Mesa's layer complains where no desktop can be asked about GPUs.
ENV NVIDIA_DRIVER_CAPABILITIES=graphics,utility NVIDIA_VISIBLE_DEVICES=all NODEVICE_SELECT=1
WORKDIR /work
ENTRYPOINT ["gpu-rt"]
