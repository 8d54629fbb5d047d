# Sourced by the tests of packages of npm. `fetch FOLDER WORK` installs what the folder pins into a new folder, without the packages' scripts.
fetch() {
    rm -rf "$2" && mkdir -p "$2"
    cp "$1"/{package.json,package-lock.json} "$2"
    npm ci --prefix "$2" --ignore-scripts --no-audit --no-fund --silent
}
